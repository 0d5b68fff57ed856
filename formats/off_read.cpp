// SPDX-License-Identifier: Apache-2.0
#include "formats/off.h"
#include "formats/text_scanner.h"

namespace diesink {

bool looks_like_off(std::span<const std::byte> bytes) {
  std::string word = first_word_of(bytes);
  for (const char* prefix : {"st", "c", "n", "4", "n"}) {
    if (word.starts_with(prefix)) word.erase(0, std::char_traits<char>::length(prefix));
  }
  return word == "off";
}

}  // namespace diesink
