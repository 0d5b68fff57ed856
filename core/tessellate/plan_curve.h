// The exact curves along which labels change, and points on them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "core/compound/compound_impl.h"
#include "core/tessellate/implicit.h"

namespace diesink {

// One of the surfaces whose meeting is a curve: a face's own surface, or the silhouette plane of a
// body's side.
struct SurfaceRef {
  static constexpr std::int32_t kBase = -1, kNone = -2, kOutline = -3;
  static constexpr std::uint8_t kSilhouetteFace = 255;
  std::int32_t solid = kNone;
  std::uint8_t face = 0;
  // On a scanned base, the triangle whose plane is meant; surfaces are the same without it.
  static constexpr std::uint32_t kWhole = 0xFFFFFFFFu;
  std::uint32_t facet = kWhole;
  friend bool operator==(const SurfaceRef& a, const SurfaceRef& b) {
    return a.solid == b.solid && a.face == b.face;
  }
};

enum class CurveType : std::uint8_t {
  kMeet,     // two faces meet at one height: a crease
  kShadow,   // a body ends: first is its visible face, second the silhouette or the face it ends at
  kOutline,  // the base ends; second's face is the side of its grid
  kUnsolved,  // found by halving alone
};

// A curve in space over its plan: the common points of two surfaces.
struct PlanCurve {
  CurveType type = CurveType::kUnsolved;
  SurfaceRef first, second;
  bool upper =
      true;  // a shadow: the end of the body's upper faces (an added body), else of its lower ones
  std::uint8_t line = 0;  // a silhouette of two lines: which of them
  [[nodiscard]] bool same_as(const PlanCurve& other) const {
    return type == other.type && line == other.line &&
           ((first == other.first && second == other.second) ||
            (first == other.second && second == other.first));
  }
  // Whether a face that has `ref` has the curve's own height. (Two paths that cannot be told apart
  // become one with the curve of either: its labels need not be the curve's.)
  [[nodiscard]] bool is_height_of(const SurfaceRef& ref) const {
    return first == ref || (type == CurveType::kMeet && second == ref);
  }
};

// A point of a curve: plan position and the height of the curve there (of the ending face, for a
// shadow).
struct CurvePoint {
  double x = 0, y = 0, z = 0;
};

// A label's height at a plan point that lies on several.
struct LabelHeight {
  Label label = kNoLabel;
  double z = 0;
};

// Makes heights within `close` of one another one number: a point where faces meet is one vertex.
void join_heights(std::vector<LabelHeight>& heights, double close);

// Which labels between two are told in place of the curve that parts the two.
enum class ThirdLabel : std::uint8_t {
  kNone,
  kToldApart,  // of a face that lies apart from both by more than rounding blurs
  kAny
};

// Solves for points on the curves of one surface. Cheap to copy; any number of threads.
class CurveSolver {
 public:
  explicit CurveSolver(const CompoundSurface::Impl& surface);

  [[nodiscard]] Implicit implicit(const SurfaceRef& ref) const;
  // The upright surface over a shadow's plan curve, where it is a plane or a quadric of its own:
  // upright sides, and the silhouettes of ellipsoids.
  [[nodiscard]] std::optional<Implicit> upright(const PlanCurve& curve) const;
  [[nodiscard]] SurfaceRef ref_of(Label label) const;

  // Height of a label's own surface over (x, y); false where it has none.
  bool height(Label label, double x, double y, double& z) const;
  // The same on the silhouette of its body: the double root, free of the root's noise.
  bool silhouette_height(Label label, double x, double y, double& z) const;

  // A height to start from for a shadow's curve over (x, y), from the body alone.
  [[nodiscard]] double shadow_height(const PlanCurve& curve, double x, double y) const;

  // The curve's point on the plan line p + t d nearest to t = t0 (in steps of |d|), z from z0 on.
  // Bound: on return both equations hold to rounding. False where Newton's method does not arrive.
  bool on_line(const PlanCurve& curve, const Vec2& p, const Vec2& d, double& t, double& z) const;

  // The common plan point of two curves near `at`; z1, z2 are the curves' own heights there.
  bool corner(const PlanCurve& one, const PlanCurve& two, Vec2& at, double& z1, double& z2) const;

  // Where a crease crosses itself near `at`: both faces have one height and one slope there.
  // False where there is no such point, or the faces are more than 1e-9 of the size apart in it.
  // Needs: heights of both faces within z of the point; neither upright there.
  // Bound: the slopes are equal to rounding.
  bool double_point(const PlanCurve& curve, Vec2& at, double& z) const;

  // False where two curves run along one another in plan at their common point: two that are one
  // line (a round bar as wide as a block) or touch, whose common point is any of many, or
  // imprecise.
  [[nodiscard]] bool cross_at(const PlanCurve& one, const PlanCurve& two, const Vec2& at, double z1,
                              double z2) const;

  // z is on the label's side of the middle of its quadric: the sheet that is seen.
  bool on_sheet(Label label, const Vec2& p, double z) const;

  // z on the label's own surface is on its face, too, to 1e-10 of the size: between the body's
  // other faces.
  bool on_face(Label label, const Vec2& p, double z) const;

  // Where the label changes between p (label a) and q (label b), both found by evaluation: the
  // curve, its point, and the heights of both labels there (NaN for a hole). Where a third label
  // shows in between and no curve parts the two: a point of it instead, if that is asked for.
  struct Change {
    PlanCurve curve;
    CurvePoint at;
    double za = 0, zb = 0;
    bool third = false;
    Vec2 third_at = Vec2::Zero();
  };
  Change change_between(Vec2 p, Label a, double za, Vec2 q, Label b, double zb,
                        ThirdLabel third) const;

 private:
  bool borders(const BodyLine& body, const PlanCurve& shadow, const Vec2& at, double z) const;
  // The two are sides that touch along a curve and do not cross.
  [[nodiscard]] bool touch_along_curve(const SurfaceRef& one, const SurfaceRef& two) const;
  // The rim of a cap of one of two sides that touch, where the other has its height: a ball at the
  // leaning end of a bar.
  bool rim_between(Label a, Label b, const Vec2& p, const Vec2& d, double z_near,
                   Change& change) const;
  // The point, on the surface of `ref`, is on the mirrored nappe of a cone.
  [[nodiscard]] bool beyond_apex(const SurfaceRef& ref, const Vec3& p) const;
  // The two faces have one tangent plane at the point: where they meet is not told to all digits.
  [[nodiscard]] bool touch_at(const PlanCurve& curve, const Vec2& at, double z) const;
  bool try_curve(const PlanCurve& curve, const Vec2& p, const Vec2& d, double z0, double& t,
                 double& z) const;

  // Of the size: rounding of heights; on a steep face a tie in plan counts by the slope.
  static constexpr double kOnFace = 1e-10;

  const CompoundSurface::Impl* surface_;
  Label base_label_ = kNoLabel;
};

}  // namespace diesink
