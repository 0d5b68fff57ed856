// What a mesh shows of each element: in how many pieces, over how much of the plan.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <numeric>
#include <string>
#include <tuple>
#include <vector>

#include "core/mesh.h"
#include "tests/support/mesh_checks.h"

namespace diesink::test {

// Connected pieces of each element, triangles joined over the sides they share.
inline std::map<std::string, int> pieces_of(const TriangleMesh& mesh) {
  std::vector<std::uint32_t> root(mesh.triangles.size());
  std::iota(root.begin(), root.end(), 0u);
  const auto find = [&](std::uint32_t k) {
    while (root[k] != k) k = root[k] = root[root[k]];
    return k;
  };
  std::map<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>, std::uint32_t> sides;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
      const auto [it, fresh] =
          sides.try_emplace({mesh.triangle_element[t], std::min(a, b), std::max(a, b)}, t);
      if (!fresh) root[find(t)] = find(it->second);
    }
  }
  std::map<std::string, int> pieces;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    if (find(t) == t) ++pieces[mesh.elements[mesh.triangle_element[t]].name];
  }
  return pieces;
}

// Plan area of each element.
inline std::map<std::string, double> plan_areas(const TriangleMesh& mesh) {
  std::map<std::string, double> areas;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& v = mesh.triangles[t];
    areas[mesh.elements[mesh.triangle_element[t]].name] +=
        0.5 * plan_area2(mesh.positions[v[0]], mesh.positions[v[1]], mesh.positions[v[2]]);
  }
  return areas;
}

}  // namespace diesink::test
