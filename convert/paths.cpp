// File names of the command line.
// SPDX-License-Identifier: Apache-2.0
#include "convert/paths.h"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>

namespace diesink {

bool has_ending(std::string_view path, std::string_view ending) {
  const auto lower = [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  };
  return path.size() > ending.size() &&
         std::equal(ending.begin(), ending.end(),
                    path.end() - static_cast<std::ptrdiff_t>(ending.size()),
                    [&](char a, char b) { return lower(a) == lower(b); });
}

Status check_folder(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  const std::string folder = slash == path.npos ? "." : path.substr(0, slash + 1);
  struct stat about {};
  if (stat(folder.c_str(), &about) == 0 && S_ISDIR(about.st_mode)) return ok();
  const std::string why =
      errno == 0 || S_ISDIR(about.st_mode) ? "is not a folder" : std::strerror(errno);
  return Error{ErrorCode::kOutput,
               "cannot be written, its folder '" + folder + "': " + why,
               {path, 0, 0, -1}};
}

std::string before_ending(const std::string& path, const std::string& insert) {
  const std::size_t slash = path.rfind('/');
  const std::size_t dot = path.rfind('.');
  const bool has_ending = dot != path.npos && (slash == path.npos || dot > slash);
  return has_ending ? path.substr(0, dot) + insert + path.substr(dot) : path + insert;
}

std::string size_text(const std::string& path) {
  struct stat about {};
  if (stat(path.c_str(), &about) != 0) return "?";
  const double bytes = static_cast<double>(about.st_size);
  char text[32];
  if (bytes < 1e3) {
    std::snprintf(text, sizeof text, "%.0f bytes", bytes);
  } else if (bytes < 1e6) {
    std::snprintf(text, sizeof text, "%.1f kB", bytes / 1e3);
  } else {
    std::snprintf(text, sizeof text, "%.1f MB", bytes / 1e6);
  }
  return text;
}

}  // namespace diesink
