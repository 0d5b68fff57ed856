// STL: which of its two kinds a file is.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cstring>
#include <string>

#include "formats/stl.h"
#include "formats/text_scanner.h"

namespace diesink {

bool is_binary_stl(const ByteSource& bytes) {
  if (bytes.size() < kStlHeaderBytes) return false;
  std::array<std::byte, 4> room;
  const std::byte* const at = bytes.at(80, room);
  if (at == nullptr) return false;
  std::uint32_t count = 0;
  std::memcpy(&count, at, 4);
  return kStlHeaderBytes + std::uint64_t{kStlFacetBytes} * count == bytes.size();
}

bool looks_like_stl(std::span<const std::byte> bytes) {
  return is_binary_stl(HeldBytes(bytes)) || first_word_of(bytes) == "solid";
}

Result<TriangleMesh> read_stl(std::span<const std::byte> bytes, const ReadOptions& options,
                              Diagnostics& diagnostics) {
  // A binary file that was cut or padded may begin with "solid" too; its zero bytes tell.
  const std::span<const std::byte> start = bytes.first(std::min<std::size_t>(bytes.size(), 512));
  const bool zeros = std::find(start.begin(), start.end(), std::byte{0}) != start.end();
  const bool ascii = !is_binary_stl(HeldBytes(bytes)) && first_word_of(bytes) == "solid" &&
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
  return read_binary_stl(HeldBytes(bytes), options, diagnostics);
}

}  // namespace diesink
