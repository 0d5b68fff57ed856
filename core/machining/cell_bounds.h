// How much stays within single cells of a lattice, at most: cells are divided until it is told.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "core/machining/cutter.h"
#include "core/machining/swept_heights.h"
#include "core/mesh.h"
#include "core/plan_bins.h"

namespace diesink {

// The distance from what is left to the part, bounded over cells that a coarser look does not
// settle. Over a box of the plan, what one move leaves is a convex function, and the part holds all
// that is below any plane let down to the surface, and all below any of its triangles; the distance
// to either is convex too, so the box's corners bound it. The least over moves, planes and
// triangles counts. Leaving moves out only loosens it: of each cell the ones are kept that are
// lowest at the points that halvings of it make, or over all of a box between them.
class CellBounds {
 public:
  // `cells`: numbers of their points of low x and y, rising, none at a hole or at the last row or
  // column. `halvings`: for the moves that are kept; they ask for 56 bytes times
  // (2^halvings + 1)^2 + 4^halvings a cell.
  CellBounds(const CutterShape& cutter, const PlanLattice& lattice, std::vector<std::size_t> cells,
             int halvings);
  CellBounds(const CellBounds&) = delete;
  CellBounds& operator=(const CellBounds&) = delete;

  // Same result for any thread count and any division into pieces.
  void add(std::span<const SweepMove> moves, int threads);

  // For each cell; infinity where no single move that is kept comes over all of a part of it.
  // Cells are halved until the bound is what is `enough` of each or they are a sixteenth. Bound:
  // certain for the true surface where the mesh lies within `deviation` of it.
  [[nodiscard]] std::vector<double> bounds(const TriangleMesh& mesh, double deviation,
                                           std::span<const double> enough, int threads) const;

 private:
  struct Kept {
    SweepMove move;
    double height = std::numeric_limits<double>::infinity();
  };
  // Point (i, j) of a cell, 0 <= i, j <= side_.
  [[nodiscard]] Vec2 point(std::size_t cell, std::size_t i, std::size_t j) const;
  void keep(std::size_t cell, const SweepMove& move, std::vector<double>& z);
  // What reaches into each tile, of `count` boxes: ascending numbers.
  template <class BoxOf>
  [[nodiscard]] std::vector<std::vector<std::uint32_t>> over_tiles(std::size_t count,
                                                                   const BoxOf& box_of) const;

  CutterShape cutter_;
  PlanLattice lattice_;
  std::vector<std::size_t> cells_;
  std::vector<PlanBox> boxes_;   // of the cells
  std::size_t side_, each_;      // boxes along a cell's side; kept moves of a cell
  std::vector<Kept> kept_;       // of each cell those of its points, then those of its boxes
  std::vector<double> highest_;  // of a cell's kept heights
  // Cells that lie close together are looked at together.
  std::vector<PlanBox> tiles_;
  std::vector<std::vector<std::uint32_t>> cells_of_;  // of each tile: places in cells_
  std::optional<PlanBins> bins_;                      // of the tiles
};

}  // namespace diesink
