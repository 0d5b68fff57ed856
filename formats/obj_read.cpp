// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>

#include "formats/obj.h"
#include "formats/text_scanner.h"

namespace diesink {

bool looks_like_obj(std::span<const std::byte> bytes) {
  constexpr std::array<std::string_view, 12> kWords{"v", "vn", "vt", "vp", "f",      "l",
                                                    "p", "o",  "g",  "s",  "mtllib", "usemtl"};
  const std::string word = first_word_of(bytes);
  return std::find(kWords.begin(), kWords.end(), word) != kWords.end();
}

}  // namespace diesink
