// From CC-data to CL-data, and the removal of interferences (Fig. 12).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/machining/cc_pass.h"
#include "core/machining/drop.h"
#include "core/machining/segment_profile.h"

namespace diesink {

// Equation (6), with the disk of a flat or bull-nose cutter besides: the tip for a contact.
Vec3 tip_of(const CutterShape& cutter, const CcContact& contact);

// The tips of a stretch of CC-data. Over a convex edge the cutter is turned about the edge in steps
// that keep `intol`; down and up the side of a jump likewise.
std::vector<Vec3> tips_of(const CutterShape& cutter, const std::vector<CcSample>& stretch,
                          double intol);

struct InterferenceCounts {
  std::size_t loops = 0;      // Fig. 12(a), (b): gouging points cut out
  std::size_t crossings = 0;  // Fig. 12(c): points put in where the offsets meet
};

// Appends the move from a to b, with points at the lowest safe height between where the straight
// move would dip more than `tolerance` under it; a itself is there already. Bound: returns the most
// that these moves lie under the lowest safe height, at most `tolerance` where a and b do not.
double safe_move(const Vec3& a, const Vec3& b, SegmentProfile& profile, double tolerance,
                 std::vector<Vec3>& out);

// Cuts the stretches of gouging tips out, puts the crossing of the two sides in, and adds points
// until no straight move lies more than `tolerance` under the lowest safe height, which the profile
// tells along the whole of each move.
// Needs: `profile` and `drop` in the program's own frame, of the same cutter; the profile's chord
//        at most a quarter of the tolerance.
// Bound: returns the most that any move of `tips` lies under the lowest safe height, at most
//        `tolerance` (tests/core/machining_cc_test.cpp).
double without_interference(std::vector<Vec3>& tips, const PointDrop& drop, SegmentProfile& profile,
                            double tolerance, InterferenceCounts& counts);

}  // namespace diesink
