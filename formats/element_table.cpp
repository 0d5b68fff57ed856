// SPDX-License-Identifier: Apache-2.0
#include "formats/element_table.h"

namespace diesink {

std::string color_name(const Color& color) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string name = "#";
  for (std::size_t i = 0; i < (color[3] == 255 ? 3U : 4U); ++i) {
    name += kDigits[color[i] >> 4];
    name += kDigits[color[i] & 15];
  }
  return name;
}

std::uint32_t ElementTable::add(MeshElement element) {
  if (!names_.insert(element.name).second) {
    const std::string first = element.name;
    for (std::size_t n = elements_.size() + 1; !names_.insert(element.name).second; ++n) {
      element.name = first + "." + std::to_string(n);
    }
  }
  elements_.push_back(std::move(element));
  return static_cast<std::uint32_t>(elements_.size() - 1);
}

std::uint32_t ElementTable::named(std::string_view name, std::string_view solid, bool as_is) {
  std::pair<std::string, std::string> key(name, solid);
  if (const auto found = by_name_.find(key); found != by_name_.end()) return found->second;
  MeshElement element{key.first, key.second, std::nullopt};
  if (element.name.empty() && !as_is) element.name = element.solid;
  if (names_.count(element.name) > 0 && !solid.empty() && !as_is)
    element.name += "." + element.solid;
  const std::uint32_t number = add(std::move(element));
  by_name_.emplace(std::move(key), number);
  return number;
}

std::uint32_t ElementTable::colored(const Color& color) {
  if (const auto found = by_color_.find(color); found != by_color_.end()) return found->second;
  const std::uint32_t number = add({color_name(color), {}, color});
  by_color_.emplace(color, number);
  return number;
}

void ElementTable::move_into(TriangleMesh& mesh) {
  const bool silent = elements_.size() == 1 && elements_[0].name.empty() &&
                      elements_[0].solid.empty() && !elements_[0].color;
  if (silent || elements_.empty()) {
    mesh.triangle_element.clear();
    return;
  }
  // One element needs no number a triangle.
  if (elements_.size() == 1) mesh.triangle_element.clear();
  mesh.elements = std::move(elements_);
}

}  // namespace diesink
