// STL: which of its two kinds a file is.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstring>
#include <string>

#include "formats/stl.h"
#include "formats/text_scanner.h"

namespace diesink {
namespace {

bool is_binary(std::span<const std::byte> bytes) {
  if (bytes.size() < kStlHeaderBytes) return false;
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + 80, 4);
  return kStlHeaderBytes + std::uint64_t{kStlFacetBytes} * count == bytes.size();
}

}  // namespace

bool looks_like_stl(std::span<const std::byte> bytes) {
  return is_binary(bytes) || first_word_of(bytes) == "solid";
}

Result<TriangleMesh> read_stl(std::span<const std::byte> bytes, const ReadOptions& options,
                              Diagnostics& diagnostics) {
  // A binary file that was cut or padded may begin with "solid" too; its zero bytes tell.
  const std::span<const std::byte> start = bytes.first(std::min<std::size_t>(bytes.size(), 512));
  const bool zeros = std::find(start.begin(), start.end(), std::byte{0}) != start.end();
  const bool ascii = !is_binary(bytes) && first_word_of(bytes) == "solid" &&
                     !(zeros && bytes.size() >= kStlHeaderBytes + kStlFacetBytes);
  if (ascii) {
    return read_ascii_stl(text_of(bytes), options, diagnostics);
  }
  if (bytes.size() < kStlHeaderBytes) {
    return Error{ErrorCode::kInput,
                 "the file has " + std::to_string(bytes.size()) +
                     " bytes, expected 'solid' or a binary header of 84 bytes",
                 {options.file_name}};
  }
  return read_binary_stl(bytes, options, diagnostics);
}

}  // namespace diesink
