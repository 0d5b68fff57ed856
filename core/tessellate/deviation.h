// How far flat triangles and straight chords are from the surfaces and curves they stand for:
// bounds that hold, without sampling.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "core/compound/compound_surface.h"
#include "core/tessellate/deviation_affine.h"
#include "core/tessellate/deviation_base.h"
#include "core/tessellate/implicit.h"
#include "core/vec.h"

namespace diesink {

// A curve in space: where two surfaces meet.
struct CurvePair {
  Implicit f, g;
};

// Upper bound of the distance between the chord a-b and the piece of the curve from a to b, both
// ways. The piece is the one that runs from a to b without turning back along the chord; that there
// is one and no other near the chord is shown first.
// Units:  mm.
// Needs:  a and b on the curve to rounding; what is left of F and G there is counted.
// Errors: infinity where it cannot be shown: long chords, nearly tangent surfaces, a base surface
//         not defined about the chord.
// Bound:  within 10 % of the distance for chords of up to 0.1 radians of turn.
double chord_deviation(const CurvePair& curve, const Vec3& a, const Vec3& b);

// How many times as long as it is thin an ellipsoid is whose triangles are bounded on the way from
// its centre, too: that way need not be along their normals.
constexpr double kLongEllipsoid = 6;

// Bounds for the triangles of a whole surface; made once, used by any number of threads.
class TriangleDeviation {
 public:
  // Needs: the surface outlives this.
  explicit TriangleDeviation(const CompoundSurface::Impl& surface);

  // Upper bound of the distance between the flat triangle and the surface behind the label (the
  // whole plane, quadric or base), both ways near the triangle: every point of the triangle has a
  // point of the surface within the bound along one common direction, and those points make up the
  // surface near it.
  // Units:  mm.
  // Needs:  vertices on a base to rounding; how far they are off a plane or quadric, and to which
  //         side, is counted.
  // Errors: infinity where no bound holds: a triangle that spans a quarter turn or so.
  // Bound:  tends to the exact distance as the triangle shrinks (tests/core/deviation_test.cpp).
  [[nodiscard]] double operator()(Label label, const Vec3& a, const Vec3& b, const Vec3& c) const;

  // The whole plane, quadric or base behind a label.
  [[nodiscard]] Implicit face(Label label) const;

  // The base's second derivatives; null where the base is not a Ferguson surface.
  [[nodiscard]] const BaseCurvature* base() const { return base_ ? &*base_ : nullptr; }

 private:
  [[nodiscard]] double over_base(const Vec3& a, const Vec3& b, const Vec3& c) const;
  bool base_gap(const PlanBox& box, const Vec3& a, const Vec3& b, const Vec3& c,
                BaseGap& out) const;

  const CompoundSurface::Impl* surface_;
  std::vector<Implicit> sides_;  // one a solid; a quadric where it has one
  std::optional<BaseCurvature> base_;
  std::optional<AffineBase> affine_;
};

}  // namespace diesink
