// The lowest height of the volumes a cutter sweeps, over a lattice: the material that stays.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/machining/sweep_depth.h"

namespace diesink {

// Plan points (x0 + i dx, y0 + j dy), row-major, x fastest.
struct PlanLattice {
  double x0 = 0, y0 = 0, dx = 1, dy = 1;
  std::size_t columns = 0, rows = 0;
  [[nodiscard]] double x(std::size_t i) const { return x0 + static_cast<double>(i) * dx; }
  [[nodiscard]] double y(std::size_t j) const { return y0 + static_cast<double>(j) * dy; }
};

// The lowest height over (x, y) of the cutter moving along the whole move; +infinity where it does
// not come over the point. To rounding.
double swept_height(const CutterShape& cutter, const SweepMove& move, double x, double y);

// The same over a lattice and all moves; +infinity where none comes.
std::vector<double> swept_heights(const CutterShape& cutter, const std::vector<SweepMove>& moves,
                                  const PlanLattice& lattice, int threads);

}  // namespace diesink
