// From a pass profile to the few points that keep its tolerances.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "core/machining/pass_profile.h"
#include "core/vec.h"

namespace diesink {

// A stretch of a pass without a gap: (x, z) of the tip, x not falling; a step is two points at one
// x.
using PassRun = std::vector<Vec2>;

// Runs of a profile whose gaps wider than `join` divide it.
// Bound: along every run the straight moves lie at most `below` under the profile and at most
// `above`
//        over it, everywhere and not only at the points (a piecewise linear profile has its extreme
//        deviations at its own corners, and all of them are examined). Corners that turn by more
//        than ten degrees, and both ends of steps, are kept as points.
// Needs: below, above >= 0; the profile as UpperEnvelope leaves it.
std::vector<PassRun> fit_runs(std::span<const ProfileSegment> profile, double below, double above,
                              double join);

}  // namespace diesink
