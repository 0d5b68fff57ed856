// The lowest height of the volumes a cutter sweeps, over a lattice: the material that stays.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
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

// The lowest of all moves over a lattice; a path is taken in pieces.
class SweptHeights {
 public:
  // `surface`: what the part is at the points, NaN where nothing.
  // Needs: `surface` outlives it.
  SweptHeights(const CutterShape& cutter, const PlanLattice& lattice,
               const std::vector<double>& surface);

  // Same result for any thread count and any division into pieces.
  void cut(std::span<const SweepMove> moves, int threads);

  // What is left at the points; +infinity where no move came.
  [[nodiscard]] const std::vector<double>& heights() const { return heights_; }
  // For each cell of the lattice (numbered as its point of low x and y): how far what is left
  // stands over the part at most, anywhere in the cell, if the part were straight between the
  // cell's points. The volume a move sweeps is convex, so over a cell the highest of one move's
  // four corners bounds it; the best of all moves counts. Infinity where no move covers the cell
  // alone.
  [[nodiscard]] const std::vector<float>& over_cells() const { return over_; }

 private:
  class Cutting;

  CutterShape cutter_;
  PlanLattice lattice_;
  const std::vector<double>* surface_;
  std::size_t tile_columns_, tile_rows_;
  std::vector<double> heights_;
  std::vector<float> over_;
  std::vector<double> highest_;  // of what a move must come below to change anything in a tile
};

}  // namespace diesink
