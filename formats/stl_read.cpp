// SPDX-License-Identifier: Apache-2.0
#include <cstring>

#include "formats/stl.h"
#include "formats/text_scanner.h"

namespace diesink {

bool looks_like_stl(std::span<const std::byte> bytes) {
  if (bytes.size() >= kStlHeaderBytes) {
    std::uint32_t count = 0;
    std::memcpy(&count, bytes.data() + 80, 4);
    if (kStlHeaderBytes + std::uint64_t{kStlFacetBytes} * count == bytes.size()) return true;
  }
  return first_word_of(bytes) == "solid";
}

}  // namespace diesink
