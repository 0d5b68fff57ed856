// What a mesh is made of.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/mesh.h"

namespace diesink {

// Counted after exact welding, unless asked otherwise.
// Units: area and volume in the mesh's unit squared and cubed.
struct MeshTopology {
  std::size_t vertices = 0;    // different positions
  std::size_t triangles = 0;   // all of them
  std::size_t lines = 0;       // segments of the curves
  std::size_t degenerate = 0;  // triangles of which two corners coincide; not counted below
  std::size_t flat = 0;        // triangles of three corners and no area
  std::size_t duplicates = 0;  // triangles with the corners of an earlier one
  std::size_t edges = 0;
  std::size_t boundary_edges = 0;        // of one triangle
  std::size_t nonmanifold_edges = 0;     // of more than two triangles
  std::size_t misoriented_edges = 0;     // of two triangles that run along it the same way
  std::size_t nonmanifold_vertices = 0;  // where surfaces touch in a point alone
  std::size_t boundary_loops = 0;
  std::size_t shells = 0;   // connected over edges
  bool watertight = false;  // every edge has two triangles that run along it opposite ways
  std::string why_not;      // empty where watertight, else e.g. "4 boundary edges in 1 loop"
  double area = 0;
  double volume = 0;  // enclosed, positive where normals point out; tells nothing unless watertight
  std::array<Vec3, 2> bounds{Vec3::Zero(),
                             Vec3::Zero()};  // of the positions that triangles or curves use
};

// `as_shared`: takes the sharing of vertices as it is instead of welding equal positions first.
MeshTopology topology_of(const TriangleMesh& mesh, bool as_shared = false);

// Vertices of the mesh, as it shares them, that belong to no triangle and no curve.
std::size_t vertices_alone(const TriangleMesh& mesh);

// What a reader warns of; a few nanoseconds a triangle.
struct OddFaces {
  std::size_t degenerate = 0;  // two corners at one position
  std::size_t duplicates = 0;  // the vertices of an earlier triangle, in any order
};
// `welded`: no two vertices have one position, which spares looking at them.
OddFaces odd_faces(const TriangleMesh& mesh, bool welded = false, int threads = 0);

// For the triangles of welded vertices: those that have the corners of an earlier one, in their
// order. The same for any number of threads.
// Memory: 2 to 4 bytes a triangle, and 48 for each whose hash is another's too: one in eight of
// those that are no duplicates.
std::vector<std::uint32_t> find_duplicates(std::span<const std::array<std::uint32_t, 3>> triangles,
                                           int threads = 0);

// A triangle's side along an edge.
struct EdgeUse {
  std::uint32_t low, high;  // the edge's vertices, low < high
  std::uint32_t corner;     // 3 * triangle + the corner the side starts at
  bool forward;             // the side runs from low to high
};

// All sides sorted by edge, then by triangle; those of a triangle with two equal corners are left
// out.
std::vector<EdgeUse> edge_uses(std::span<const std::array<std::uint32_t, 3>> triangles,
                               std::size_t vertices);

// Calls `see` with the uses of one edge after the other.
template <class See>
void for_each_edge(std::span<const EdgeUse> uses, See see) {
  for (std::size_t first = 0; first < uses.size();) {
    std::size_t last = first + 1;
    while (last < uses.size() && uses[last].low == uses[first].low &&
           uses[last].high == uses[first].high)
      ++last;
    see(uses.subspan(first, last - first));
    first = last;
  }
}

// The corner of the use's triangle at its low, or high, vertex.
inline std::uint32_t corner_at_low(const EdgeUse& use) {
  return use.forward ? use.corner : use.corner - use.corner % 3 + (use.corner % 3 + 1) % 3;
}
inline std::uint32_t corner_at_high(const EdgeUse& use) {
  return use.forward ? use.corner - use.corner % 3 + (use.corner % 3 + 1) % 3 : use.corner;
}

// Sets that grow together. The root of a set is its smallest member.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count);
  std::uint32_t find(std::uint32_t member);
  void join(std::uint32_t a, std::uint32_t b);

 private:
  std::vector<std::uint32_t> parent_;
};

}  // namespace diesink
