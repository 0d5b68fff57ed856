// Meshes over a plan lattice from a height function: for tests of what works on meshes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include "core/mesh.h"

namespace diesink::test {

// nx by ny points over [x0, x1] x [y0, y1]; a NaN height is a hole.
inline TriangleMesh height_mesh(double x0, double x1, std::uint32_t nx, double y0, double y1,
                                std::uint32_t ny,
                                const std::function<double(double, double)>& height) {
  TriangleMesh mesh;
  for (std::uint32_t j = 0; j < ny; ++j) {
    for (std::uint32_t i = 0; i < nx; ++i) {
      const double x = i + 1 == nx ? x1 : x0 + (x1 - x0) * i / (nx - 1);
      const double y = j + 1 == ny ? y1 : y0 + (y1 - y0) * j / (ny - 1);
      mesh.positions.emplace_back(x, y, height(x, y));
    }
  }
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    for (const std::uint32_t v : {a, b, c}) {
      if (std::isnan(mesh.positions[v].z())) return;
    }
    mesh.triangles.push_back({a, b, c});
  };
  for (std::uint32_t j = 0; j + 1 < ny; ++j) {
    for (std::uint32_t i = 0; i + 1 < nx; ++i) {
      const std::uint32_t v = j * nx + i;
      if ((i + j) % 2 == 0) {
        add(v, v + 1, v + nx + 1);
        add(v, v + nx + 1, v + nx);
      } else {
        add(v, v + 1, v + nx);
        add(v + 1, v + nx + 1, v + nx);
      }
    }
  }
  return mesh;
}

}  // namespace diesink::test
