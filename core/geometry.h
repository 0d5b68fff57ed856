// The convex bodies a part program is made of, as checked geometry in program coordinates.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "core/vec.h"

namespace diesink {

// The plane n·r + d = 0, n unit length and pointing out of the body.
struct Plane {
  Vec3 n = Vec3::UnitZ();
  double d = 0;
};

struct PolyhedronFace {
  std::vector<std::uint8_t> loop;  // 3 or 4 vertex indices, anticlockwise seen from outside
  Plane plane;                     // fitted to the loop (Newell), outward
  std::uint8_t number = 1;         // the k of "facek", from 1
};

// A closed convex polyhedron of 4 to 8 vertices. Faces that degenerate to a line or point are left out,
// the numbers of the others stay.
struct Polyhedron {
  std::vector<Vec3> vertices;
  std::vector<PolyhedronFace> faces;
};

enum class QuadricShape : std::uint8_t { kCone, kCylinder, kEllipsoid, kParaboloid };

// A quadric body at its zero position in the frame (n, o, a) at p: u = n·(r-p), v = o·(r-p), w = a·(r-p).
//   cone        (u/A)² + (v/B)² <= (1 - w/C)²,  0 <= w <= C     faces: side, bottom (w = 0)
//   cylinder    (u/A)² + (v/B)² <= 1,           0 <= w <= C     faces: side, bottom (w = 0), top (w = C)
//   ellipsoid   (u/A)² + (v/B)² + (w/C)² <= 1                   face:  surface
//   paraboloid  (u/A)² + (v/A)² <= w,           0 <= w <= C     faces: side, top (w = C)    [A² = 4·focal length]
// Source: equation (9) and the transform before (10).
struct QuadricBody {
  QuadricShape shape = QuadricShape::kEllipsoid;
  Vec3 p = Vec3::Zero();
  Mat3 frame = Mat3::Identity();  // rows n, o, a: orthonormal, right-handed
  double A = 1, B = 1, C = 1;
};

using Body = std::variant<Polyhedron, QuadricBody>;

// Face numbers of quadric bodies; polyhedra use 1.. ("face1"), the base surface 0.
inline constexpr std::uint8_t kFaceSide = 1;    // "side", or "surface" of an ellipsoid
inline constexpr std::uint8_t kFaceBottom = 2;  // "bottom"
inline constexpr std::uint8_t kFaceTop = 3;     // "top"

// "side", "surface", "bottom", "top", "face1"..; needs a number the body has.
std::string face_name(const Body& body, std::uint8_t number);

// Faces the body has, ascending.
std::vector<std::uint8_t> face_numbers(const Body& body);

// Axis-aligned box of the body, exact to rounding: {low, high}.
std::array<Vec3, 2> bounds_of(const Body& body);

}  // namespace diesink
