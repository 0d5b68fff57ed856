// Second derivatives of a base surface over the plan, bounded once and looked up often.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "core/base/base_surface.h"
#include "core/base/ferguson.h"

namespace diesink {

// Bounds of slopes and second derivatives over part of the plan.
struct BaseShape {
  Range zx, zy;
  Range zxx, zxy, zyy;
};

// A pyramid of plan lattices over a Ferguson surface. Each cell asks the surface for its enclosure
// when it is first needed and keeps it; any number of threads may ask at once, and what they get
// does not depend on their order.
class BaseCurvature {
 public:
  // Needs: the surface outlives this.
  explicit BaseCurvature(const FergusonSurface& surface);
  ~BaseCurvature();
  BaseCurvature(BaseCurvature&&) noexcept;
  BaseCurvature& operator=(BaseCurvature&&) noexcept;

  // Certain bounds over a plan box, wherever the surface is defined there; false where it is
  // nowhere.
  // Bound: those of a box at most half as large again on every side, the finest cells apart.
  bool over(const PlanBox& box, BaseShape& shape) const;

 private:
  struct Cell;
  struct Level {
    int columns = 1, rows = 1;
    double width = 0, height = 0;
    std::unique_ptr<Cell[]> cells;
  };
  void take(const Level& level, int column, int row, BaseShape& shape, bool& any) const;

  const FergusonSurface* surface_;
  PlanBox box_;
  std::vector<Level> levels_;  // coarsest first
};

}  // namespace diesink
