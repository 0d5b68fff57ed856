// Runs over the places that a path leaves too high, until none is left or no run helps.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/machining/left_over.h"
#include "core/machining/path_links.h"
#include "core/machining/segment_profile.h"
#include "core/machining/uncut_proof.h"

namespace diesink {

// Of a radius, the spacing of the lattice.
inline constexpr double kLatticePart = 32;

// Of what may stay: a little less is called out, for what is between the lattice's points, and
// half of it makes a cutter one that is of use.
inline LeftOverLimits left_over_limits(double limit) { return {0.8 * limit, limit, 0.5 * limit}; }

// What a cutter has to leave over a place for that to be out of its reach: more than OUTTOL; less
// where little more may stay, as the path has to be told from it.
inline double out_of_reach(double outtol, double limit) {
  constexpr double kPart = 0.4;
  return outtol < kPart * limit ? outtol : kPart * limit;
}

struct ClosingOptions {
  double below = 0;  // no move dips deeper under the lowest safe height
  double above = 0;  // points of a run this close to a straight move are left out
  double lift = 0;   // from the offset's cutter to the one that cuts
  bool oneway = false;
  int threads = 0;
};

// Cuts runs over rows of the lattice, first far apart, then closer, where the rows before did not
// help. Counts closing_runs of the report.
// Needs: `left` has every move so far and is given those of `joiner` as they come. Bound: returns
// the most by which a move lies under the lowest safe height of the offset's cutter.
double close_left_over(LeftOver& left, SegmentProfile& profile, const ClosingOptions& options,
                       const PathStream& stream, PathJoiner& joiner, PathReport& report);

// Proves that no more than the limit stays between the lattice's points either; cuts runs where
// that fails and a cutter fits, and tells in left_area, left_height and unsettled_area where they
// do not help. What stays where no cutter fits is added to unreachable_area. Needs: `proof` has
// every move so far and is given those of `joiner` as they come. Bound: as close_left_over.
double close_unproven(UncutProof& proof, LeftOver& left, SegmentProfile& profile,
                      const ClosingOptions& options, const PathStream& stream, PathJoiner& joiner,
                      PathReport& report);

// Adds what still stays to left_area, left_height and left_spacing of the report.
void tell_left_over(LeftOver& left, PathReport& report);

}  // namespace diesink
