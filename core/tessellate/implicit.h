// A face's surface, or the silhouette of a body, as the zero set of a smooth function of space.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "core/compound/body_line.h"
#include "core/compound/compound_surface.h"
#include "core/vec.h"

namespace diesink {

// Second derivatives over a region: every Hessian there is `middle` plus a matrix of Frobenius norm
// at most `spread`.
struct HessianBound {
  Mat3 middle = Mat3::Zero();
  double spread = 0;
};

// A function of space, small enough to pass by value. Its form F is
//   plane    n·(r - c) - d, n unit (or zero: see silhouette_implicit)
//   quadric  k0 u² + k1 v² + k2 w² + l w + m, with (u, v, w) the axes of the body about c; a
//   length,
//            negative inside the body
//   base     z - zB(x, y)
// value() is F divided by the length of its gradient, so that it is the signed distance to first
// order.
// Units:  mm.
// Bound:  value() errs by a few 1e-16 of the distance between r and c (base: of the base's own
//         bound), however far from the origin both are.
struct Implicit {
  enum class Kind : std::uint8_t { kPlane, kQuadric, kBase };

  Kind kind = Kind::kPlane;
  Vec3 c = Vec3::Zero();
  Vec3 n = Vec3::UnitZ();         // plane
  double d = 0;                   // plane
  Mat3 frame = Mat3::Identity();  // quadric: rows are its axes
  Vec3 k = Vec3::Zero();
  double l = 0, m = 0;
  const CompoundSurface::Impl* surface = nullptr;  // base; not owned

  // F and its gradient; NaN where a base surface is not defined.
  double form(const Vec3& r, Vec3& gradient) const;

  // value() and its gradient, to first order near the surface: the gradient of F over its length, a
  // unit vector (zero at the apex of a cone and for a constant).
  double evaluate(const Vec3& r, Vec3& gradient) const;
  [[nodiscard]] double value(const Vec3& r) const {
    Vec3 gradient;
    return evaluate(r, gradient);
  }
  [[nodiscard]] Vec3 gradient(const Vec3& r) const {
    Vec3 gradient;
    evaluate(r, gradient);
    return gradient;
  }

  // Second derivatives of F over all points whose coordinates are within `margin` of one of the
  // chord a-b.
  [[nodiscard]] HessianBound hessian(const Vec3& a, const Vec3& b, double margin) const;
};

// The whole plane or quadric that a face is part of. Positive outside the body.
// Needs: a face the body has.
Implicit face_implicit(const BodyLine& body, std::uint8_t face);

// The surface behind a label: a body's as above; the base, positive above it.
// Needs: the surface outlives the result where the label is the base's.
Implicit face_implicit(const CompoundSurface::Impl& surface, Label label);

// The plane of a triangle of a scanned base, positive above it.
// Needs: such a base, and a triangle with an area in plan.
Implicit facet_implicit(const CompoundSurface::Impl& surface, std::uint32_t facet);

// The plane that holds the silhouette of a body's quadric side, the polar plane of the vertical:
// positive where the outward normal points up. A side without silhouette (upright cylinder or
// paraboloid) gives n = 0 and the value 1, -1 or 0 everywhere.
// Needs: body.has_side().
Implicit silhouette_implicit(const BodyLine& body);

}  // namespace diesink
