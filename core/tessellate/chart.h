// Flat maps of the die's faces, for triangulating them in the plane.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "core/compound/compound_surface.h"
#include "core/tessellate/chart_turn.h"
#include "core/tessellate/deviation.h"
#include "core/tessellate/implicit.h"
#include "core/vec.h"

namespace diesink {

// The chart of the surface behind a label (its whole plane, quadric or base, not only the body's
// part of it), on the side that is seen from above: the upper one of an added body, the lower one
// of a subtracted body. It is continuous and one to one up to and including the silhouette and
// keeps the turn of the plan: what lies to the left of a curve in plan does so in the chart.
// Lengths in the chart are about those on the face; where a face is straight one way (cylinders,
// cones) it is drawn shorter that way, up to kRulingStretch, so that triangles regular in the chart
// are long along the rulings.
//   plane       its own plane; horizontal: x and y
//   cylinder    unrolled
//   cone        unrolled; as a disk about the apex where all of its side is seen
//   ellipsoid   stereographic, in the affine image that is a sphere, from the point farthest hidden
//   paraboloid  along its axis, the deep part drawn wider
//   base        x and y
// A cone's apex is a singular point: a region that holds it should have it as a vertex.
// Units:  mm.
// Immutable; any number of threads.
class FaceChart {
 public:
  static constexpr double kRulingStretch = 2.7;

  // Needs: the surface, and the curvature where given, outlive the chart. `curvature` saves the
  //        enclosures of a Ferguson base from being worked out anew for every spacing().
  FaceChart(const CompoundSurface::Impl& surface, Label label,
            const BaseCurvature* curvature = nullptr);

  // Draws an ellipsoid as the sphere that it is but for its axes where that takes fewer triangles:
  // as long and narrow as it is, where regular ones would be as small as its edge is sharp.
  // Needs: to be called before anything is drawn.
  void draw_for(double tolerance);

  // Needs: p on the seen side of the face, to rounding.
  [[nodiscard]] Vec2 to_chart(const Vec3& p) const;

  // The point of the face behind a chart point; false where there is none or it is on the side that
  // is not seen.
  // Bound: within 1e-13 of the surface's size of the exact surface.
  bool from_chart(const Vec2& c, Vec3& p) const;

  // Chart length of the edges of a regular triangle about p that keeps the tolerance, just;
  // infinity on planes. An estimate: TriangleDeviation is the bound.
  [[nodiscard]] double spacing(const Vec3& p, double tolerance) const;

  // Spheres, ellipsoids, paraboloids: chords leave such a face on one side only, and are longer
  // between vertices that stand off on the other.
  [[nodiscard]] bool bends_every_way() const {
    return kind_ == Kind::kEllipsoid || kind_ == Kind::kParaboloid;
  }

  // Moves a point of the face up or down, to the outside of its body, until it stands off the face
  // by the part given of the tolerance, or less where the face is steep or the tolerance coarse
  // beside its radius; the way, along the normal.
  // Needs: bends_every_way(). (The triangles of other faces end on borders that stay.)
  double stand_off(double part, double tolerance, Vec3& p) const;

  // Unit normal that points up; at the silhouette level, and on the same side as nearby.
  [[nodiscard]] Vec3 normal(const Vec3& p) const;

  // An ellipsoid kLongEllipsoid times as long as it is thin (deviation.h).
  [[nodiscard]] bool is_long() const {
    return kind_ == Kind::kEllipsoid && axes_.maxCoeff() >= kLongEllipsoid * axes_.minCoeff();
  }

  [[nodiscard]] bool is_plane() const { return kind_ == Kind::kPlane; }

  // The ruling of a cylinder or cone through p, by a number that grows with the chart's x or turn;
  // none on other faces, and in an apex.
  [[nodiscard]] std::optional<double> turn(const Vec3& p) const;
  [[nodiscard]] bool has_rulings() const {
    return kind_ == Kind::kCylinder || kind_ == Kind::kCone;
  }
  // By how much it grows once round.
  [[nodiscard]] double whole_turn() const { return turns_.last() - turns_.first(); }

  // The apex of a cone whose side this is.
  [[nodiscard]] std::optional<Vec3> apex() const;

 private:
  enum class Kind : std::uint8_t { kPlane, kCylinder, kCone, kEllipsoid, kParaboloid, kBase };

  void prepare_plane();
  void prepare_turning(const QuadricBody& body);
  [[nodiscard]] double triangles_of_ellipsoid(double tolerance) const;
  void prepare_ellipsoid(const QuadricBody& body);
  void prepare_paraboloid(const QuadricBody& body);
  [[nodiscard]] double turn_of(double u, double v) const;
  [[nodiscard]] Vec3 ruling(double turn) const;
  [[nodiscard]] double radius_of(double x) const;
  [[nodiscard]] double radius_inverse(double radius) const;
  [[nodiscard]] double base_spacing(const Vec3& p, double tolerance) const;

  Kind kind_ = Kind::kPlane;
  double side_ = 1;  // +1: the outward normal points up, -1: the inward one
  Implicit face_;
  const BaseCurvature* curvature_ = nullptr;
  Mat3 frame_ = Mat3::Identity();  // rows: axes of the chart's own coordinates about face_.c
  Vec3 axes_ = Vec3::Ones();       // A, B, C of the body
  double mirror_ = 1;              // factor of one chart coordinate that keeps the turn of the plan
  // Cylinder and cone: the angle of the middle of the seen side, and the length around from there.
  double cos_start_ = 1, sin_start_ = 0;
  TurnTable turns_;
  // Cone: chart radius = scale (slant / slant of the rim)^power,
  // chart angle = fan * developed angle - shift.
  double slant_ = 1, scale_ = 1, power_ = 1, fan_ = 1, shift_ = 0;
  // Ellipsoid: rows e1, e2, m (image of the vertical, towards the seen side) in the unit sphere,
  // and the scale of e1 and e2.
  Mat3 sphere_ = Mat3::Identity();
  Vec2 stretch_ = Vec2::Ones();
  bool as_sphere_ = false;  // by draw_for()
  // Paraboloid: slope from where on the deep part is drawn wider, and its exponent.
  double steep_ = 0, widening_ = 1;
};

}  // namespace diesink
