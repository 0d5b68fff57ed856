// SPDX-License-Identifier: Apache-2.0
#include "core/counted.h"

namespace diesink {

std::string counted(std::size_t count, std::string_view words) {
  const std::size_t many = words.find('|') + 1, rest = words.find('|', many) + 1;
  std::string text = std::to_string(count) + " ";
  text += count == 1 ? words.substr(0, many - 1) : words.substr(many, rest - many - 1);
  text += words.substr(rest);
  return text;
}

}  // namespace diesink
