// What coordinates hardly tell apart in the graph of cells becomes one: corners at one place, ways
// out and back, slivers between two curves.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/tessellate/cell_graph.h"

namespace diesink {

// Of the size: how far apart the two roots may come out where two curves touch. Of a height some
// 1e-12 is rounding and the tie that decides what shows; the root of that, with room. The curves
// part there by its square, 1e-11 or less: a hundredth of what vertices of curves are held to.
constexpr double kDoubleRoot = 3e-6;

// Where a face ends in a silhouette and meets another face at the silhouette's height both curves
// touch in plan, so that for a stretch nothing tells them apart and what evaluation shows between
// them comes and goes from cell to cell. Such a sliver is taken away as a whole and the corner that
// it opens at is put where the equations say.
// Bound:  what is taken away is nowhere wider than 1e-9 of the size.
void draw_together(const CompoundSurface::Impl& surface, const ArrangementOptions& options,
                   CellGraph& graph);

}  // namespace diesink
