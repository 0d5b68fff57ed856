// The profile of one pass: the tip's height along a row of the offset surface, piecewise linear.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/machining/offset_surface.h"

namespace diesink {

// Heights are linear from (x0, z0) to (x1, z1); piece counts as in OffsetSurface::box().
struct ProfileSegment {
  double x0 = 0, z0 = 0, x1 = 0, z1 = 0;
  std::uint32_t piece = 0;
};

// Appends what piece k of the offset surface adds to the row y, clipped to [x0, x1]: a facet's own
// line, or chords of the concave height over an edge or vertex.
// Bound: the chords lie at most `chord` below the true height, never above it.
void slice_piece(const OffsetSurface& offset, std::uint32_t k, double y, double x0, double x1,
                 double chord, std::vector<ProfileSegment>& out);

// A straight line in plan, for profiles that do not lie along the frame's rows.
struct PlanLine {
  PlanLine(const Vec2& a, const Vec2& b) : from(a), length((b - a).norm()) {
    if (length > 0) {
      dx = (b.x() - a.x()) / length;
      dy = (b.y() - a.y()) / length;
    }
  }
  // Along the line from its start, and to its left.
  [[nodiscard]] Vec2 to_line(const Vec2& p) const {
    const double ox = p.x() - from.x(), oy = p.y() - from.y();
    return {ox * dx + oy * dy, oy * dx - ox * dy};
  }
  [[nodiscard]] Vec2 at(double along) const {
    return {from.x() + along * dx, from.y() + along * dy};
  }
  Vec2 from;
  double length = 0, dx = 1, dy = 0;
};

// As slice_piece, along any line: x counts from its start.
void slice_piece_along(const OffsetSurface& offset, std::uint32_t k, const PlanLine& line,
                       double chord, std::vector<ProfileSegment>& out);

// The upper envelope of the segments, ascending in x, interiors disjoint; where two follow each
// other at different heights there is a step, where none covers there is a gap. Works in place; O(n
// log n).
class UpperEnvelope {
 public:
  void take(std::vector<ProfileSegment>& segments);

 private:
  struct Chain {
    double end = 0;
    std::uint32_t index = 0;
  };
  std::vector<ProfileSegment> other_;
  std::vector<Chain> open_;  // a heap, the one that ends first on top
  std::vector<std::uint32_t> chain_of_;
  std::vector<std::size_t> ends_, next_ends_;
};

}  // namespace diesink
