// The border of a Ferguson base: points on it and how far its chords are off.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/compound/compound_impl.h"
#include "core/tessellate/implicit.h"

namespace diesink {

// Where the base ends on the plan line p + t d, near t = 0, and its height there: by halving, for
// the border of a warped base has no equation in plan.
// Bound:  on the base's side of its border, within rounding of it. False where none is found within
//         |d| of p.
bool outline_on_line(const CompoundSurface::Impl& surface, const Vec2& p, const Vec2& d, double& t,
                     double& z);

// Which side of a Ferguson base's grid a border point is on: 0 the first row, 1 the last column, 2
// the last row, 3 the first column.
int outline_side(const CompoundSurface::Impl& surface, const Vec2& p);

// The grid's corner between two of its sides; false where they do not meet.
bool outline_vertex(const CompoundSurface::Impl& surface, int one, int two, Vec3& at);

// Upper bound of the distance between the chord a-b and the base's border from a to b, both ways.
// A side of the border is a piecewise cubic of its parameter w: linear interpolation of it errs by
// at most |r''| (w1 - w0)² / 8.
// Needs:  a and b, in plan, on the border to rounding; what they are off is counted.
// Errors: infinity where they are not on one side of a Ferguson base's border.
double outline_chord_deviation(const CompoundSurface::Impl& surface, const Vec2& a, const Vec2& b);

// Where the border meets the plan of the curve f = g = 0 near `at`; z is the curve's height there,
// z_base the base's. An implicit of the base's own kind stands for the base.
// Bound:  both equations and the border hold to rounding. False where Newton's method does not
//         arrive.
bool outline_corner(const CompoundSurface::Impl& surface, const Implicit& f, const Implicit& g,
                    Vec2& at, double& z, double& z_base);

}  // namespace diesink
