// The values in the body of a PLY file, one after the other.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <string>

#include "core/result.h"
#include "formats/ply_header.h"
#include "formats/text_scanner.h"

namespace diesink {

// Every read checks what is left; after a failure `failed` holds the error. begin_row() gives the
// row's place, end_row() and finish() leave the cursor where it ends.
class AsciiValues {
 public:
  explicit AsciiValues(TextScanner& text) : text_(text) {}
  static constexpr std::size_t bytes(PlyType) {
    return 2;
  }  // a digit and a blank; the last blank may be missing
  [[nodiscard]] std::size_t left() const { return text_.left() + 1; }

  bool read(PlyType type, double& value) {
    text_.more();
    const NumberState state = text_.number(value);
    if (state == NumberState::kOk && (is_real(type) || fits(type, value))) return true;
    if (state == NumberState::kNotFinite && is_real(type)) {
      // Let the caller decide whether the value matters.
      text_.word();
      value = std::numeric_limits<double>::quiet_NaN();
      return true;
    }
    failed = state == NumberState::kOk
                 ? text_.error("a whole number of its property's type was expected")
                 : text_.number_error(state, "a value");
    return false;
  }
  const char* begin_row() {
    text_.more();
    return text_.at();
  }
  // A row's end: the rest of its line is left out, and counted.
  void end_row() {
    if (!text_.more_in_line()) return;
    longer.hit(text_.at());
    text_.rest_of_line();
  }
  void finish() {}
  std::optional<Error> failed;
  Tally longer;

 private:
  static bool fits(PlyType type, double value) {
    const std::size_t bits = size_of(type) * 8;
    const bool is_signed =
        type == PlyType::kInt8 || type == PlyType::kInt16 || type == PlyType::kInt32;
    const auto top = static_cast<double>(std::uint64_t{1} << (bits - (is_signed ? 1U : 0U)));
    if (!(value < top && value >= (is_signed ? -top : 0))) return false;
    return static_cast<double>(static_cast<std::int64_t>(value)) == value;
  }
  TextScanner& text_;
};

template <bool kSwapped>
class BinaryValues {
 public:
  explicit BinaryValues(TextScanner& text) : text_(text) {}
  static constexpr std::size_t bytes(PlyType type) { return size_of(type); }
  [[nodiscard]] std::size_t left() const { return text_.left(); }

  bool read(PlyType type, double& value) {
    const std::size_t size = size_of(type);
    if (text_.left() < size) {
      failed = Error{ErrorCode::kInput, "the file ends within its data", {}};
      return false;
    }
    std::uint64_t bits = 0;
    std::memcpy(&bits, text_.at(), size);
    text_.move_to(text_.at() + size);
    if constexpr (kSwapped) bits = __builtin_bswap64(bits) >> (64 - 8 * size);
    switch (type) {
      case PlyType::kInt8:
        value = static_cast<std::int8_t>(bits);
        break;
      case PlyType::kUint8:
        value = static_cast<std::uint8_t>(bits);
        break;
      case PlyType::kInt16:
        value = static_cast<std::int16_t>(bits);
        break;
      case PlyType::kUint16:
        value = static_cast<std::uint16_t>(bits);
        break;
      case PlyType::kInt32:
        value = static_cast<std::int32_t>(bits);
        break;
      case PlyType::kUint32:
        value = static_cast<std::uint32_t>(bits);
        break;
      case PlyType::kFloat:
        value = static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits)));
        break;
      case PlyType::kDouble:
        value = std::bit_cast<double>(bits);
        break;
    }
    return true;
  }
  const char* begin_row() { return text_.at(); }
  void end_row() {}
  void finish() {}
  std::optional<Error> failed;
  Tally longer;

 private:
  TextScanner& text_;
};

}  // namespace diesink
