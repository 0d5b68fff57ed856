// The triangles of a mesh element by element, for formats that write one group after the other.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/mesh.h"

namespace diesink {

// Shape: triangles[begin[e]] .. triangles[begin[e + 1] - 1] are those of element e, in the mesh's
// own order;
//        begin has one entry more than there are elements, of which there is at least one.
struct ElementRuns {
  std::vector<std::uint32_t> triangles;
  std::vector<std::size_t> begin;

  [[nodiscard]] std::size_t count() const { return begin.size() - 1; }
  [[nodiscard]] std::span<const std::uint32_t> of(std::size_t element) const {
    return std::span(triangles).subspan(begin[element], begin[element + 1] - begin[element]);
  }
};

ElementRuns element_runs(const TriangleMesh& mesh);

// The element a triangle belongs to.
inline std::uint32_t element_of(const TriangleMesh& mesh, std::size_t triangle) {
  return mesh.triangle_element.empty() ? 0 : mesh.triangle_element[triangle];
}

// The text with every control character replaced by '_', so that it stays on one line.
std::string one_line(std::string_view text);

// "crease", "edge", "jump", "curve".
std::string_view name_of(CurveKind kind);

// What a curve is called where a format has groups: "crease:S2.side|S3.surface",
// "jump:S2.top|S2.wall|name" or "curve:name".
std::string curve_label(const TriangleMesh& mesh, const MeshCurve& curve);
// The way back, looking up the elements by name; false where `label` is no such label.
bool read_curve_label(std::string_view label, const TriangleMesh& mesh, MeshCurve& curve);

}  // namespace diesink
