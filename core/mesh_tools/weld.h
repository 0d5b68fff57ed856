// Vertices that coincide become one.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/mesh.h"

namespace diesink {

struct WeldMap {
  std::vector<std::uint32_t>
      of_vertex;  // the number of the vertex it becomes, ascending by first appearance
  std::vector<std::uint32_t> kept;  // the old number of each vertex that stays
};

// Equal positions become one (-0 equals 0). Needs finite positions.
WeldMap weld_map(std::span<const Vec3> positions);

// A position becomes the nearest of those kept before it that lies within `tolerance`, else it is
// kept itself: kept positions are more than `tolerance` apart, none moves by more. The same answer
// for the same order. Needs: finite positions, tolerance > 0.
WeldMap weld_map(std::span<const Vec3> positions, double tolerance);

struct WeldReport {
  std::size_t merged_vertices = 0;
  std::size_t collapsed_triangles =
      0;  // two corners became one: removed when tolerance > 0, else kept
};

// Welds a mesh in place: tolerance 0 exactly. The first position and colour of those that become
// one are kept; normals, elements and curves follow.
WeldReport weld(TriangleMesh& mesh, double tolerance = 0);

// Removes the triangles whose entry is false, with what belongs to them; vertices stay.
// Needs: one entry a triangle.
void keep_triangles(TriangleMesh& mesh, const std::vector<bool>& keep);

}  // namespace diesink
