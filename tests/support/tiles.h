// The tiles of a domain made one by one, and what has to hold where they meet. Knows nothing of how
// seams are made: it reads the meshes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <unordered_map>
#include <vector>

#include "core/tessellate/tessellate.h"
#include "tests/support/mesh_checks.h"

namespace diesink::test {

using PointBits = std::array<std::uint64_t, 3>;

inline PointBits bits_of(const Vec3& p) {
  return {std::bit_cast<std::uint64_t>(p.x()), std::bit_cast<std::uint64_t>(p.y()),
          std::bit_cast<std::uint64_t>(p.z())};
}

// A side that only one triangle has, in the sense that it runs along it.
struct OpenSide {
  std::uint32_t from = 0, to = 0;
};

inline std::vector<OpenSide> open_sides(const TriangleMesh& mesh) {
  std::map<std::array<std::uint32_t, 2>, int> sides;
  for (const auto& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) ++sides[{t[k], t[(k + 1) % 3]}];
  }
  std::vector<OpenSide> open;
  for (const auto& [side, count] : sides) {
    if (!sides.contains({side[1], side[0]})) open.push_back({side[0], side[1]});
  }
  return open;
}

// How often the open sides run round: loops, those that share a vertex counted as one.
inline std::size_t open_loops(const TriangleMesh& mesh) {
  std::unordered_map<std::uint32_t, std::uint32_t> root;
  const auto find = [&](std::uint32_t v) {
    root.try_emplace(v, v);
    while (root[v] != v) v = root[v] = root[root[v]];
    return v;
  };
  for (const OpenSide& s : open_sides(mesh)) root[find(s.from)] = find(s.to);
  std::size_t loops = 0;
  for (const auto& [v, r] : root) loops += v == r ? 1u : 0u;
  return loops;
}

struct Tiling {
  std::array<int, 2> tiles{1, 1};
  std::vector<Tessellation> made;  // x fastest
  [[nodiscard]] const Tessellation& at(int i, int j) const {
    return made[static_cast<std::size_t>(j * tiles[0] + i)];
  }
};

// Each tile by itself; throws what is refused.
inline Tiling make_tiles(const CompoundSurface& surface, TessellationOptions options,
                         const std::array<int, 2>& tiles) {
  Tiling tiling;
  tiling.tiles = options.tiles = tiles;
  for (int j = 0; j < tiles[1]; ++j) {
    for (int i = 0; i < tiles[0]; ++i) {
      options.tile = {i, j};
      Result<Tessellation> made = tessellate(surface, options);
      if (!made) throw std::runtime_error(to_text(made.error()));
      tiling.made.push_back(std::move(*made));
    }
  }
  return tiling;
}

// The open sides of a mesh on the line where coordinate `axis` is `at`, ends by their bits; `turn`
// runs along them the other way.
inline std::multiset<std::array<PointBits, 2>> sides_on(const TriangleMesh& mesh, int axis,
                                                        double at, bool turn) {
  std::multiset<std::array<PointBits, 2>> sides;
  for (const OpenSide& s : open_sides(mesh)) {
    const Vec3 &p = mesh.positions[s.from], &q = mesh.positions[s.to];
    if (p[axis] != at || q[axis] != at) continue;
    sides.insert(turn ? std::array{bits_of(q), bits_of(p)} : std::array{bits_of(p), bits_of(q)});
  }
  return sides;
}

// Neighbours end in the same sides, run along the other way; and cover their stretch.
inline void check_seams(const Tiling& tiling, bool everywhere, Faults& faults) {
  const auto& [columns, rows] = tiling.tiles;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      for (int axis = 0; axis < 2; ++axis) {
        const int i1 = i + (axis == 0 ? 1 : 0), j1 = j + (axis == 1 ? 1 : 0);
        if (i1 >= columns || j1 >= rows) continue;
        const Tessellation &one = tiling.at(i, j), &two = tiling.at(i1, j1);
        const std::size_t high = axis == 0 ? 1 : 3, low = axis == 0 ? 0 : 2;
        const double at = one.report.domain[high];
        const std::string name = " of tile " + std::to_string(i) + "," + std::to_string(j) +
                                 (axis == 0 ? " to the right" : " to the back");
        if (at != two.report.domain[low]) faults.add("the cut" + name, at, two.report.domain[low]);
        const auto mine = sides_on(one.mesh, axis, at, false);
        const auto other = sides_on(two.mesh, axis, at, true);
        if (mine != other) {
          std::size_t missing = 0;
          for (const auto& s : mine) missing += other.contains(s) ? 0u : 1u;
          faults.add("the seam" + name + " is not the same: " + std::to_string(mine.size()) +
                     " sides and " + std::to_string(other.size()) + ", of which " +
                     std::to_string(missing) + " have no counterpart");
        }
        if (everywhere && mine.empty()) faults.add("nothing on the seam" + name);
      }
    }
  }
}

// All tiles in one mesh; vertices on cuts that are equal to the bit are one.
inline TriangleMesh welded(const Tiling& tiling) {
  TriangleMesh all;
  std::map<PointBits, std::uint32_t> on_cuts;
  std::map<std::string, std::uint32_t> element_of;
  for (int j = 0; j < tiling.tiles[1]; ++j) {
    for (int i = 0; i < tiling.tiles[0]; ++i) {
      const Tessellation& made = tiling.at(i, j);
      const auto& d = made.report.domain;
      const TriangleMesh& mesh = made.mesh;
      std::vector<std::uint32_t> number;
      for (const Vec3& p : mesh.positions) {
        const bool cut = (i > 0 && p.x() == d[0]) || (i + 1 < tiling.tiles[0] && p.x() == d[1]) ||
                         (j > 0 && p.y() == d[2]) || (j + 1 < tiling.tiles[1] && p.y() == d[3]);
        const auto fresh = static_cast<std::uint32_t>(all.positions.size());
        const std::uint32_t v = cut ? on_cuts.try_emplace(bits_of(p), fresh).first->second : fresh;
        if (v == fresh) all.positions.push_back(p);
        number.push_back(v);
      }
      std::vector<std::uint32_t> element;
      for (const MeshElement& e : mesh.elements) {
        const auto [it, fresh] =
            element_of.try_emplace(e.name, static_cast<std::uint32_t>(all.elements.size()));
        if (fresh) all.elements.push_back(e);
        element.push_back(it->second);
      }
      const auto normals = static_cast<std::uint32_t>(all.normals.size());
      all.normals.insert(all.normals.end(), mesh.normals.begin(), mesh.normals.end());
      for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto &v = mesh.triangles[t], &n = mesh.corner_normals[t];
        all.triangles.push_back({number[v[0]], number[v[1]], number[v[2]]});
        all.corner_normals.push_back({normals + n[0], normals + n[1], normals + n[2]});
        all.triangle_element.push_back(element[mesh.triangle_element[t]]);
      }
    }
  }
  return all;
}

}  // namespace diesink::test
