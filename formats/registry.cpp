// SPDX-License-Identifier: Apache-2.0
#include "formats/registry.h"

#include <algorithm>
#include <array>
#include <string>

namespace diesink {
namespace {

// An explicit table: in a static library the linker drops objects that only register themselves.
// Content is tried in this order, so that formats with a magic word come before those that are only
// likely.
constexpr std::array kFormats{&kStl, &kObj, &kPly, &kOff, &kGltf, &kGlb};

}  // namespace

std::span<const Format* const> all_formats() { return kFormats; }

const Format* format_of_content(std::span<const std::byte> bytes, std::string_view file_name) {
  // The file's own ending breaks the tie where several formats could hold these bytes.
  const Format* const named = format_of_ending(file_name);
  if (named != nullptr && named->matches(bytes)) return named;
  for (const Format* format : kFormats) {
    if (format->matches(bytes)) return format;
  }
  return named;
}

const Format* format_of_ending(std::string_view file_name) {
  const std::size_t dot = file_name.rfind('.');
  if (dot == std::string_view::npos || file_name.find('/', dot) != std::string_view::npos)
    return nullptr;
  std::string ending(file_name.substr(dot));
  for (char& c : ending) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  for (const Format* format : kFormats) {
    if (std::find(format->extensions.begin(), format->extensions.end(), ending) !=
        format->extensions.end()) {
      return format;
    }
  }
  return nullptr;
}

}  // namespace diesink
