// Where the plan of a scan may end: its edges with triangles on one side in plan.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <mutex>
#include <vector>

#include "core/base/scanned.h"

namespace diesink {

// The edges with triangles on their left alone in plan. Edges that lie on one another in plan, one
// with its triangles on either side, are none.
std::vector<ScannedSurface::BorderEdge> plan_border(
    const std::vector<Vec3>& positions, const std::vector<std::array<std::uint32_t, 3>>& triangles);

// Worked out on the first call that asks, for most evaluations never do.
struct ScannedSurface::Border {
  std::once_flag once;
  std::vector<BorderEdge> edges;            // the triangles on the left
  std::vector<std::uint32_t> start, items;  // edges of each cell of the plan grid
};

}  // namespace diesink
