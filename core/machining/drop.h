// The drop: the lowest tip at which a cutter touches a mesh from above, exact to rounding.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "core/machining/offset_surface.h"

namespace diesink {

// Tip heights over the lattice x0 + i dx (i < columns), ys[j], in the frame of `offset`, row-major,
// x fastest; kNoContact where the cutter meets nothing. Needs: ys ascending; dx > 0; heights.size()
// == columns * ys.size(). Bound: the highest contact of the mesh to rounding, 1e-12 of its largest
// coordinate
//        (tests/core/machining_drop_test.cpp).
// Same bytes for any thread count; threads 0 = all cores.
void drop_lattice(const OffsetSurface& offset, double x0, double dx, std::size_t columns,
                  std::span<const double> ys, std::span<double> heights, int threads);

// Single points in any order: the pieces of the offset surface in the cells of a plan grid.
class PointDrop {
 public:
  // Needs: `offset` outlives it.
  explicit PointDrop(const OffsetSurface& offset);

  // Tip height over a plan point of the offset's frame. May be called from several threads.
  [[nodiscard]] double at(double x, double y) const;

  // Appends the pieces that reach the plan segment from a to b and can lift the tip above `floor`,
  // each at least once.
  void pieces_along(const Vec2& a, const Vec2& b, double floor,
                    std::vector<std::uint32_t>& pieces) const;

 private:
  struct Entry {
    float top = 0;  // rounded up
    std::uint32_t piece = 0;
  };
  const OffsetSurface* offset_;
  PlanBox extent_;
  int nx_ = 1, ny_ = 1;
  double inv_dx_ = 0, inv_dy_ = 0;
  std::vector<std::uint32_t> start_;
  std::vector<Entry> items_;
};

}  // namespace diesink
