// How deep a triangle reaches into the volume a cutter sweeps along a straight move.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "core/machining/cutter.h"
#include "core/vec.h"

namespace diesink {

struct SweepMove {
  Vec3 from = Vec3::Zero(), to = Vec3::Zero();  // tips
};

// Depths in [found, bound]; both 0 where it is certain that nothing reaches deeper than asked
// about.
struct SweepDepth {
  double found = 0, bound = 0;
};

// The depth of a point is its distance to the swept volume's outside; of the triangle's points the
// deepest counts. Depths up to `floor` do not matter and may come out as 0. The cutter's shank ends
// at the height `ceiling`, which must lie above everything. The cutter shrunk by m all round still
// meets the triangle exactly where the depth is m or more; that is decided by the distance between
// convex bodies (Gilbert, Johnson and Keerthi, 1988), whose every step bounds the distance from
// both sides. Bound: bound - found <= 1e-9 of the cutter's radius, or what is left after 60 steps.
SweepDepth sweep_depth(const CutterShape& cutter, const SweepMove& move,
                       const std::array<Vec3, 3>& triangle, double floor, double ceiling);

}  // namespace diesink
