// Arcs and helices in paths that are read: replaced by chords, of which it is known how far they
// lie from the arc. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "core/units.h"
#include "core/vec.h"
#include "formats/path_text.h"

namespace diesink {

// A turn about an axis. Along the axis it moves on evenly.
struct PathArc {
  Vec3 center = Vec3::Zero();
  Vec3 axis = Vec3::UnitZ();  // unit length
  double turn = 0;            // radians, positive by the right hand about the axis
};

// The turn from one point to another about an axis, in (0, 2 pi]: equal points are a whole turn
// apart.
double turn_between(const Vec3& center, const Vec3& axis, const Vec3& from, const Vec3& to);

// Distance of a point from an axis.
double radius_about(const Vec3& center, const Vec3& axis, const Vec3& p);

// Whether two radii are those of one circle but for the digits of a post-processor: they differ by
// no more than 0.01 mm (0.0004 inches) or a thousandth, as controllers allow it.
bool same_radius(double a, double b, LengthUnit unit);

// Adds the arc from the last point to `to` as chords. Returns how far they may lie from it: the
// chords' height, 0.0001 mm or, of large arcs, a thousand-millionth of the radius, and what the
// radii at its ends differ by. Needs: a last point; radii that are not 0.
double add_arc(PointsRead& points, const Vec3& to, const PathArc& arc, Motion motion,
               LengthUnit unit);

}  // namespace diesink
