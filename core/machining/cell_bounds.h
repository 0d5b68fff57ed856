// How much stays within single cells of a lattice, at most: cells are divided until it is told.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
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
// that is below any plane let down to the surface; the distance to that is convex too, so the box's
// corners bound it. The least over moves and planes counts. Leaving moves out only loosens it: of
// each cell the ones that are lowest at nine points are kept.
class CellBounds {
 public:
  // `cells`: numbers of their points of low x and y, rising, none at a hole or at the last row or
  // column. `part`: heights at the lattice's points. Needs: `part` outlives it.
  CellBounds(const CutterShape& cutter, const PlanLattice& lattice, const std::vector<double>& part,
             std::vector<std::size_t> cells);
  CellBounds(const CellBounds&) = delete;
  CellBounds& operator=(const CellBounds&) = delete;

  // Same result for any thread count and any division into pieces.
  void add(std::span<const SweepMove> moves, int threads);

  // For each cell; infinity where no single move comes over all of it or a wall runs through it.
  // Cells are halved until the bound is `enough` or they are a sixteenth. Bound: certain for the
  // true surface where the mesh lies within `deviation` of it.
  [[nodiscard]] std::vector<double> bounds(const TriangleMesh& mesh, double deviation,
                                           double enough, int threads) const;

 private:
  static constexpr std::size_t kSamples = 9;
  struct Kept {
    std::array<SweepMove, kSamples> move;
    std::array<double, kSamples> height;
  };
  [[nodiscard]] Vec2 sample(std::size_t cell, std::size_t k) const;
  // What reaches into each tile, of `count` boxes: ascending numbers.
  template <class BoxOf>
  [[nodiscard]] std::vector<std::vector<std::uint32_t>> over_tiles(std::size_t count,
                                                                   const BoxOf& box_of) const;

  CutterShape cutter_;
  PlanLattice lattice_;
  std::vector<std::size_t> cells_;
  std::vector<double> spread_;  // a move so much higher in a cell's middle is passed over
  std::vector<Kept> kept_;
  // Cells that lie close together are looked at together.
  std::vector<PlanBox> tiles_;
  std::vector<std::vector<std::uint32_t>> cells_of_;  // of each tile: places in cells_
  std::optional<PlanBins> bins_;                      // of the tiles
};

}  // namespace diesink
