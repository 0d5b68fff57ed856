// Edge detection on the grid array (paper, Fig. 8): where neighbours lie on different faces.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/grid/grid_array.h"

namespace diesink {

enum class EdgeKind : std::uint8_t {
  kCrease,  // two faces meet at one height
  kEdge,    // the surface ends: a hole, or the base's own border
  kJump,    // two faces at different heights: a wall between them
};

// "crease", "edge", "jump".
const char* name_of(EdgeKind kind);

// One side of an edge: a plan point, what lies over it, and its label.
struct EdgeSide {
  double x = 0, y = 0;
  std::optional<CcDatum> datum;  // empty where there is no surface
  Label label = kNoLabel;
};

// CC-data on either side of an edge, `first` at the smaller coordinate: neighbouring doubles of x
// (along a row) or y (along a column) with different labels.
struct EdgePair {
  EdgeKind kind = EdgeKind::kCrease;
  bool along_x = true;         // found along a row of the grid, else along a column
  std::uint32_t i = 0, j = 0;  // the grid point before it
  EdgeSide first, second;
};

// All changes of label between neighbouring points of the grid, row by row along x, then along y;
// each narrowed by bisection until no double lies between its two points. Where a midpoint shows a
// third label both halves are searched, so that several edges between two neighbours are all given
// that a midpoint meets; a face between two points of one label that no midpoint meets is not seen.
// A jump is a difference of height that neither the tie tolerance nor the slope of a steep face
// over the gap explains. The same for any number of threads.
std::vector<EdgePair> find_edges(const CompoundSurface& surface, const GridArray& grid,
                                 int threads);

// The same between any two plan points, which become the ends of the search; `along_x` and i, j
// stay as they are. Appends to `out`.
void find_edges_between(const CompoundSurface& surface, const Vec2& from, const Vec2& to,
                        std::vector<EdgePair>& out);

}  // namespace diesink
