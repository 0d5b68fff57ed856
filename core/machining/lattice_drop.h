// The drop on the lattice of the passes, exact to rounding.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "core/machining/offset_surface.h"

namespace diesink {

// Tip heights over the lattice x0 + i dx (i < columns), ys[j], in the frame of `offset`, row-major,
// x fastest; kNoContact where the cutter meets nothing.
// Needs: ys ascending; dx > 0; heights.size() == columns * ys.size().
// Bound: the highest contact of the mesh to rounding, 1e-12 of its largest coordinate
//        (tests/core/machining_drop_test.cpp).
// Same bytes for any thread count; threads 0 = all cores.
void drop_lattice(const OffsetSurface& offset, double x0, double dx, std::size_t columns,
                  std::span<const double> ys, std::span<double> heights, int threads);

}  // namespace diesink
