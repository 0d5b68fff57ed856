// The header of a PLY file.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "formats/text_scanner.h"

namespace diesink {

enum class PlyType : std::uint8_t {
  kInt8,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kFloat,
  kDouble
};

// Bytes a value takes in a binary file.
constexpr std::size_t size_of(PlyType type) {
  switch (type) {
    case PlyType::kInt8:
    case PlyType::kUint8:
      return 1;
    case PlyType::kInt16:
    case PlyType::kUint16:
      return 2;
    case PlyType::kInt32:
    case PlyType::kUint32:
    case PlyType::kFloat:
      return 4;
    case PlyType::kDouble:
      break;
  }
  return 8;
}

constexpr bool is_real(PlyType type) { return type == PlyType::kFloat || type == PlyType::kDouble; }

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kFloat;  // of a list: of its items
  bool list = false;
  PlyType count_type = PlyType::kUint8;
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
  const char* named_at = nullptr;  // in the header, for messages

  // The property of this name, or null.
  [[nodiscard]] const PlyProperty* find(std::string_view property) const;
};

enum class PlyEncoding : std::uint8_t { kAscii, kLittleEndian, kBigEndian };

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::kAscii;
  std::vector<PlyElement> elements;
  std::vector<std::string_view> comments;  // the text after `comment` or `obj_info`
};

// Reads up to and with the line end after `end_header`; exactly one line end, since what follows
// may be binary.
Result<PlyHeader> read_ply_header(TextScanner& text);

}  // namespace diesink
