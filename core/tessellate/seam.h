// The border that two tiles of a domain share, as one chain of points for both.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/compound/compound_impl.h"
#include "core/tessellate/cell_tree.h"
#include "core/tessellate/line_changes.h"
#include "core/tessellate/plan_curve.h"
#include "core/tessellate/tessellate.h"

namespace diesink {

// A point of a seam: a change of label, or one between changes where both labels are the same.
struct SeamPoint {
  double along = 0;
  bool change = false;
  Label low = kNoLabel, high = kNoLabel;  // towards lower and higher coordinates
  PlanCurve curve;                        // of a change
  std::vector<LabelHeight> heights;       // one a label
};

// A stretch of a cut between tiles, from the corner of a tile to the next; points ascend and leave
// out both ends.
struct Seam {
  int axis = 0;  // the coordinate that is fixed: 0 x, 1 y
  double at = 0, from = 0, to = 0;
  std::vector<SeamPoint> points;
  // On both sides of what could not be told apart along it; the place is in the first such piece.
  double unsettled_area = 0;
  Vec2 unsettled_place = Vec2::Zero();

  [[nodiscard]] std::size_t changes() const;
};

struct SeamOptions {
  PlanBox domain;        // of all tiles
  double tolerance = 0;  // of the faces beside
  double sag = 0;        // largest distance of chords from the surface
  double shortest = 0;   // no chord is made shorter
  LineLimits search;     // of what changes along it
  const std::vector<double>* grid =
      nullptr;  // set: points where the seam crosses these lines, and at changes, nothing else
  // A scanned base along the seam: its vertices, by their place along it and height, ascending. All
  // of them that are seen are points, and nothing else of the base.
  std::vector<Vec2> profile;
};

// The sides of a tile: bottom, right, top, left.
struct TileSides {
  std::array<bool, 4> cut;         // between two tiles
  std::array<double, 4> at;        // the coordinate that is fixed
  std::array<double, 4> from, to;  // ends of the side's seam
  static int axis(std::size_t side) { return side % 2 == 1 ? 0 : 1; }

  // `inset`: of borders of the domain, see border_inset().
  TileSides(const PlanBox& box, const TessellationOptions& options, double inset);
};

// A function of the surface, the line and the options alone: tiles on both sides get the same bits.
// Chords keep the sag, are short enough for triangles within the tolerance on either side, and get
// shorter where something comes near, so that no tile has to split them.
Seam make_seam(const CompoundSurface::Impl& surface, int axis, double at, double from, double to,
               const SeamOptions& options);

}  // namespace diesink
