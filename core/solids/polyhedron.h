// A checked convex polyhedron from corners and faces.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry.h"
#include "core/result.h"

namespace diesink {

// Corners of a face in order; the faces of one body run the same way round, outward or inward all.
struct FaceCorners {
  std::array<std::uint8_t, 4> corner{};
  std::uint8_t count = 0;
};

// The most by which a corner may lie off its face or outside another one, in the body's size
// (diagonal of its box).
inline constexpr double kPlanarity = 1e-6;

// Corners nearer than this, in the body's size, are one: the rounding of coordinates that were
// computed.
inline constexpr double kCoincidence = 1e-11;

// The body of corners P1.. and faces face1..: corners that coincide become one vertex, faces that
// collapse to a line are left out with their numbers, loops come out anticlockwise from outside. A
// face whose corners share a coordinate, or stand above each other, gets a plane that is exactly
// parallel to that axis. Needs: at most 8 corners; faces that close up (each edge twice, once
// either way). Errors: face not planar or crossing itself, body not convex, body without volume;
// without a place.
Result<Body> make_polyhedron(std::span<const Vec3> corners, std::span<const FaceCorners> faces);

// Faces no wider in plan than `width`, a length, become upright, through their first corner: walls
// of a solid that leans, which the last digits of its corners have tilted.
// Bound: no corner lies farther than `width` off its face for that.
void stand_upright(Polyhedron& body, double width);

}  // namespace diesink
