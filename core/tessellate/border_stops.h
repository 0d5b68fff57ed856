// Corners on the border of the domain, and where arcs end on it in the order of travel round it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/tessellate/cell_graph.h"

namespace diesink {

// Makes a corner on the border and the changes of label on the border beside it one node: what is
// between them is nothing. A hair off or outside counts as on it where curves touch the border.
void pull_to_border(const CompoundSurface::Impl& surface, const ArrangementOptions& options,
                    CellGraph& graph);

// A node of the graph on the border, a corner of the domain, or several of them that are one.
struct BorderStop {
  double along = 0;  // the way from the domain's lower left corner, anticlockwise
  PlanNode node;
  Label before = kNoLabel, after = kNoLabel;  // travelling that way
  std::uint8_t side =
      0;  // of the domain, that the way on from here runs along: 0 bottom, 1 right, ..
  std::vector<std::uint32_t> graph;  // nodes, in the order of travel; none: nothing ends here
};

// Needs: `inner`, where the cells end, a hair inside the domain (border_inset).
// Shape: the stops in the order of travel, the first at `along` = 0 or the next to it. Links of the
//        graph that run from one stop to itself and nowhere else are marked as gone.
std::vector<BorderStop> border_stops(const CompoundSurface::Impl& surface, CellGraph& graph,
                                     const PlanBox& domain, const PlanBox& inner,
                                     const std::array<const Seam*, 4>& seams);

}  // namespace diesink
