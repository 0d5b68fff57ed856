// The elements of a mesh while it is read.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_set>
#include <utility>
#include <vector>

#include "core/mesh.h"

namespace diesink {

using Color = std::array<std::uint8_t, 4>;

// "#1e90ff", what an element is called that only its colour tells from others.
std::string color_name(const Color& color);

// Gives out element numbers. Names are made unique by what tells the elements apart, or a number.
class ElementTable {
 public:
  // The element with this name and solid; made when first asked for. One without a name is called
  // as its solid is, unless `as_is`.
  std::uint32_t named(std::string_view name, std::string_view solid, bool as_is = false);
  // The element of this colour alone.
  std::uint32_t colored(const Color& color);
  // A new element even where the name is there already (STL's solids).
  std::uint32_t add(MeshElement element);

  [[nodiscard]] std::size_t size() const { return elements_.size(); }
  [[nodiscard]] std::vector<MeshElement>& elements() { return elements_; }

  // Puts the elements into `mesh`, unless all there is says nothing: one element without name,
  // solid and colour.
  void move_into(TriangleMesh& mesh);

 private:
  std::vector<MeshElement> elements_;
  std::unordered_set<std::string> names_;
  std::map<std::pair<std::string, std::string>, std::uint32_t> by_name_;
  std::map<Color, std::uint32_t> by_color_;
};

}  // namespace diesink
