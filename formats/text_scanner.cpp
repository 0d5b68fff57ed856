// SPDX-License-Identifier: Apache-2.0
#include "formats/text_scanner.h"

namespace diesink {

std::string_view text_of(std::span<const std::byte> bytes) {
  // The standard lets any object be looked at as char.
  std::string_view text(static_cast<const char*>(static_cast<const void*>(bytes.data())),
                        bytes.size());
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  return text;
}

std::string first_word_of(std::span<const std::byte> bytes) {
  const std::string_view text = text_of(bytes);
  std::size_t at = 0;
  while (at < text.size() && (is_blank(text[at]) || is_line_end(text[at]) || text[at] == '#')) {
    if (text[at] == '#') {
      while (at < text.size() && !is_line_end(text[at])) ++at;
    } else {
      ++at;
    }
  }
  std::string word;
  for (; at < text.size() && word.size() < 15 && !is_blank(text[at]) && !is_line_end(text[at]);
       ++at) {
    const char c = text[at];
    if (c < 0x21 || c > 0x7E) return {};
    word += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  }
  return word;
}

}  // namespace diesink
