// SPDX-License-Identifier: Apache-2.0
#include "formats/file_marks.h"

#include <array>
#include <string>
#include <utility>

#include "formats/text_scanner.h"

namespace diesink {
namespace {

// The text after `word`, an optional colon and blanks; nothing where it begins otherwise.
std::string_view after(std::string_view text, std::string_view word) {
  if (!text.starts_with(word)) return {};
  text.remove_prefix(word.size());
  if (text.empty() || (text[0] != ':' && !is_blank(text[0]))) return {};
  while (!text.empty() && (text[0] == ':' || is_blank(text[0]))) text.remove_prefix(1);
  return text;
}

}  // namespace

LengthUnit unit_of(std::string_view word) {
  using Name = std::pair<std::string_view, LengthUnit>;
  constexpr std::array kNames{Name{"mm", LengthUnit::kMillimetre},
                              Name{"millimetre", LengthUnit::kMillimetre},
                              Name{"millimeter", LengthUnit::kMillimetre},
                              Name{"millimetres", LengthUnit::kMillimetre},
                              Name{"millimeters", LengthUnit::kMillimetre},
                              Name{"cm", LengthUnit::kCentimetre},
                              Name{"centimeters", LengthUnit::kCentimetre},
                              Name{"centimetres", LengthUnit::kCentimetre},
                              Name{"m", LengthUnit::kMetre},
                              Name{"metres", LengthUnit::kMetre},
                              Name{"meters", LengthUnit::kMetre},
                              Name{"in", LengthUnit::kInch},
                              Name{"inch", LengthUnit::kInch},
                              Name{"inches", LengthUnit::kInch}};
  std::string lower(word.substr(0, 16));
  for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  for (const Name& name : kNames) {
    if (name.first == lower) return name.second;
  }
  return LengthUnit::kUnknown;
}

void read_mark(std::string_view comment, TriangleMesh& mesh) {
  if (const std::string_view unit = after(comment, "units"); !unit.empty()) {
    if (mesh.unit == LengthUnit::kUnknown) mesh.unit = unit_of(unit);
  } else if (const std::string_view up = after(comment, "up"); !up.empty()) {
    if (mesh.up == UpAxis::kUnknown && up.size() == 1) {
      if (up[0] == 'z' || up[0] == 'Z') mesh.up = UpAxis::kZ;
      if (up[0] == 'y' || up[0] == 'Y') mesh.up = UpAxis::kY;
    }
  } else if (const std::string_view name = after(comment, "name"); !name.empty()) {
    if (mesh.name.empty()) mesh.name = std::string(name);
  }
}

}  // namespace diesink
