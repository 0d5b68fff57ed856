// Chords of plane sections of convex bodies.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/tessellate/deviation.h"
#include "core/vec.h"

namespace diesink {

// Upper bound of the distance between the chord a-b and the piece from a to b of a plane section of
// an ellipsoid, cylinder or paraboloid, both ways. The section is the rim of a convex set, so that
// the piece lies between its chord and its tangents at a and b. However sharply it turns, as where
// a plane cuts off next to nothing of a long cylinder, that bound holds.
// Units:  mm.
// Needs:  a and b on both to rounding; what is left there is counted.
// Errors: infinity where the two are not such a pair, or where the piece turns a quarter and more
//         from its chord at an end.
// Source: supporting lines of convex sets.
double section_chord_deviation(const CurvePair& curve, const Vec3& a, const Vec3& b);

}  // namespace diesink
