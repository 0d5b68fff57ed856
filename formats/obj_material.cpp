// SPDX-License-Identifier: Apache-2.0
#include "formats/obj_material.h"

#include <sys/stat.h>

#include <cstdlib>
#include <memory>

#include "formats/input_file.h"
#include "formats/mesh_builder.h"
#include "formats/text_scanner.h"

namespace diesink {
namespace {

constexpr std::size_t kMaxLibraryBytes = std::size_t{16} << 20;

std::string real_path(const std::string& path) {
  const std::unique_ptr<char, decltype(&std::free)> real{::realpath(path.c_str(), nullptr),
                                                         &std::free};
  return real ? real.get() : std::string();
}

void read_library(std::string_view content, const std::string& path,
                  std::map<std::string, Color, std::less<>>& colors, Diagnostics& diagnostics) {
  TextScanner text(content, path);
  std::string name;
  // Grey and opaque until it says otherwise; a material without a colour has no entry.
  const auto color_of = [&](const std::string& material) -> Color& {
    return colors.emplace(material, Color{204, 204, 204, 255}).first->second;
  };
  Tally bad;
  while (text.more()) {
    const char* const start = text.at();
    const std::string_view word = text.word();
    if (word == "newmtl") {
      name = std::string(text.rest_of_line());
    } else if (word == "Kd") {
      Color& color = color_of(name);
      double value = 0;
      for (std::size_t i = 0; i < 3; ++i) {
        if (text.number(value) != NumberState::kOk) {
          bad.hit(start);
          break;
        }
        color[i] = color_part(value, false);
      }
    } else if (word == "d" || word == "Tr") {
      double value = 0;
      if (text.number(value) == NumberState::kOk) {
        color_of(name)[3] = color_part(word == "d" ? value : 1 - value, false);
      } else {
        bad.hit(start);
      }
    }
    text.skip_line();
  }
  bad.warn("colour|colours| of the material library cannot be read", text, diagnostics);
}

}  // namespace

bool stays_inside(std::string_view name) {
  if (name.empty() || name[0] == '/' || name.find('\\') != std::string_view::npos ||
      name.find(':') != std::string_view::npos || name.find('\0') != std::string_view::npos) {
    return false;
  }
  for (std::size_t first = 0; first <= name.size();) {
    const std::size_t slash = std::min(name.find('/', first), name.size());
    if (name.substr(first, slash - first) == "..") return false;
    first = slash + 1;
  }
  return true;
}

void read_materials(const std::string& folder, std::string_view name, const Place& where,
                    std::map<std::string, Color, std::less<>>& colors, Diagnostics& diagnostics) {
  const auto refuse = [&](const std::string& why) {
    diagnostics.warning(
        "material library " + quoted(name) + " " + why + ": its colours are missing", where);
  };
  if (folder.empty()) return refuse("has no folder to be looked for in");
  if (!stays_inside(name)) return refuse("is not inside the file's folder");
  const std::string path = folder + "/" + std::string(name);
  const std::string real = real_path(path), real_folder = real_path(folder);
  if (real.empty()) return refuse("is not there");
  if (!real.starts_with(real_folder == "/" ? "/" : real_folder + "/"))
    return refuse("is not inside the file's folder");
  struct stat found {};
  if (::stat(real.c_str(), &found) != 0 || !S_ISREG(found.st_mode)) return refuse("is no file");
  const Result<InputBytes> content = read_file(real, kMaxLibraryBytes);
  if (!content) return refuse("cannot be read (" + content.error().message + ")");
  read_library(text_of(content->bytes()), path, colors, diagnostics);
}

}  // namespace diesink
