// Scans for tests of the scanned base.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <random>
#include <utility>

#include "core/base/scanned.h"
#include "tests/support/height_mesh.h"

namespace diesink::test {

inline ScannedSurface scan_of(TriangleMesh mesh, const MeshBase& base = {}) {
  Result<ScannedSurface> surface = ScannedSurface::make(std::move(mesh), base);
  EXPECT_TRUE(surface) << (surface ? "" : surface.error().message);
  return std::move(*surface);
}

// A noisy relief whose inner vertices are shaken in plan, so that edges lie every way.
inline TriangleMesh shaken_relief(std::uint32_t n, std::uint32_t seed, double shake = 0.3) {
  TriangleMesh mesh = height_mesh(-7, 33, n, 2, 42, n, [](double x, double y) {
    return 3 * std::sin(x / 5) * std::cos(y / 4);
  });
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> part(-1, 1);
  const double cell = 40.0 / (n - 1);
  for (std::uint32_t j = 0; j < n; ++j) {
    for (std::uint32_t i = 0; i < n; ++i) {
      Vec3& p = mesh.positions[j * n + i];
      if (i > 0 && i + 1 < n && j > 0 && j + 1 < n) {
        p.x() += shake * cell * part(random);
        p.y() += shake * cell * part(random);
      }
      p.z() += 0.2 * part(random);
    }
  }
  return mesh;
}

}  // namespace diesink::test
