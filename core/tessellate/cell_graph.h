// The cells' borders searched for label changes, and the changes joined inside the cells.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/tessellate/arrangement.h"
#include "core/tessellate/cell_tree.h"
#include "core/tessellate/line_changes.h"

namespace diesink {

// A node of the graph: a label change on a cell border, or a corner inside a cell.
struct GraphNode {
  double x = 0, y = 0;
  Label low = kNoLabel,
        high = kNoLabel;  // changes: labels on the side of lower and of higher coordinate
  PlanCurve curve;
  std::vector<LabelHeight> heights;
  std::vector<std::uint32_t> links;  // corners: anticlockwise; changes: at most two
  bool corner = false, border = false, solved = true;
  std::int8_t side = -1;  // on the border: 0 bottom, 1 right, 2 top, 3 left
};

// A stretch of arc inside one cell.
struct GraphLink {
  std::uint32_t from = 0, to = 0;
  Label left = kNoLabel, right = kNoLabel;
  PlanCurve curve;
  bool gone = false;  // drawn together to a point
};

struct CellGraph {
  std::vector<GraphNode> nodes;
  std::vector<GraphLink> links;
  double uncertified_area = 0;
  Vec2 uncertified_place = Vec2::Zero();  // in the first cell of that area
  bool keeps_seams = true;                // false: a cell holds for plain what a seam crosses
};

// Splits cells of the tree further where their borders tell more than their kind allows.
CellGraph make_graph(const CompoundSurface::Impl& surface, CellTree& tree,
                     const ArrangementOptions& options);

}  // namespace diesink
