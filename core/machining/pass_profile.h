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

// The upper envelope of the segments, ascending in x, interiors disjoint; where two follow each
// other at different heights there is a step, where none covers there is a gap. Works in place; O(n
// log n).
class UpperEnvelope {
 public:
  void take(std::vector<ProfileSegment>& segments);

 private:
  std::vector<ProfileSegment> other_;
  std::vector<std::size_t> ends_, next_ends_;
};

}  // namespace diesink
