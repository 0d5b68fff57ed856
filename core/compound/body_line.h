// A convex body made ready for vertical lines: where the line (x, y) enters and leaves it, and
// through which faces. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/base/base_surface.h"
#include "core/geometry.h"

namespace diesink {

// Where a vertical line meets a body: [lower, upper] and the face number at either end.
struct LineHit {
  double lower = 0, upper = 0;
  std::uint8_t lower_face = 0, upper_face = 0;
};

// The quadric side of a body over the plan: with dx = x - cx, dy = y - cy, t = z - cz,
//   q(t) = q2 t² + 2 q1 t + q0,  q1 = b0 + bx dx + by dy,
//   q0 = c0 + cx1 dx + cy1 dy + cxx dx² + cxy dx dy + cyy dy², and the discriminant q1² - q2 q0 as
//   a polynomial of its own (d...), built about the centre so that it does not cancel near the
//   silhouette.
// q <= 0 inside. Source: equations (9), (10).
struct SideQuadratic {
  double cx = 0, cy = 0, cz = 0;
  double q2 = 0;
  double b0 = 0, bx = 0, by = 0;
  double c0 = 0, cx1 = 0, cy1 = 0, cxx = 0, cxy = 0, cyy = 0;
  double d0 = 0, dx1 = 0, dy1 = 0, dxx = 0, dxy = 0, dyy = 0;
  double disc_slack =
      0;  // a discriminant above -disc_slack counts as touching (closed bodies, rounding)
};

// How the side bounds the line.
enum class SideRule : std::uint8_t {
  kBetween,     // inside between the two roots (q2 > 0)
  kBelowFirst,  // cone steeper than its side, apex up: inside below the lower root
  kAboveLast,   // the same, apex down: inside above the upper root
  kColumn,      // upright cylinder: inside everywhere or nowhere
};

// Half-space a x + b y + c <= slack in plan: faces that stand upright, and the line through a
// cone's apex that keeps its mirrored nappe out.
struct PlanHalf {
  double a = 0, b = 0, c = 0;
  std::uint8_t face = 0;
};

// A face that bounds the line from above (upper) or below: z = z0 + zx x + zy y about (cx, cy) of
// the body.
struct PlanarCap {
  double z0 = 0, zx = 0, zy = 0;
  std::uint8_t face = 0;
};

// Prepared body. Immutable; any number of threads.
class BodyLine {
 public:
  // Needs: slack >= 0, the plan length within which a line beside the body still touches it (see
  // CompoundSurface).
  BodyLine(const Body& body, double slack);

  // True where the line meets the closed body.
  bool meet(double x, double y, LineHit& hit) const;

  // Height alone of one face's own surface (its plane or the root of its quadric on the upper or
  // lower side), whether or not the body ends there; false where the surface has no point over (x,
  // y).
  bool face_height(std::uint8_t face, bool upper, double x, double y, double& z) const;

  // Unit normal out of the body at a point of a face.
  [[nodiscard]] Vec3 normal(std::uint8_t face, const Vec3& point) const;

  [[nodiscard]] const PlanBox& plan_box() const { return box_; }
  [[nodiscard]] double z_low() const { return z_low_; }
  [[nodiscard]] double z_high() const { return z_high_; }

  // The parts, for row evaluation and bounds.
  [[nodiscard]] const Body& body() const { return *body_; }
  [[nodiscard]] bool has_side() const { return has_side_; }
  [[nodiscard]] const SideQuadratic& side() const { return side_; }
  [[nodiscard]] SideRule side_rule() const { return rule_; }
  [[nodiscard]] const std::vector<PlanarCap>& upper_caps() const { return upper_caps_; }
  [[nodiscard]] const std::vector<PlanarCap>& lower_caps() const { return lower_caps_; }
  [[nodiscard]] const std::vector<PlanHalf>& halves() const { return halves_; }
  // Straight silhouettes, of a cylinder or of a cone without its apex in sight: the shadow of the
  // side is where every a dx + b dy + c <= 0, d from the centre. Empty where the silhouette is a
  // conic, or there is none.
  [[nodiscard]] const std::vector<PlanHalf>& silhouette_lines() const { return silhouette_lines_; }
  [[nodiscard]] double center_x() const { return side_.cx; }
  [[nodiscard]] double center_y() const { return side_.cy; }
  [[nodiscard]] double slack() const { return slack_; }

 private:
  void prepare(const Polyhedron& body);
  void prepare(const QuadricBody& body);
  void prepare_silhouette_lines(const QuadricBody& body);

  const Body* body_;
  SideQuadratic side_;
  SideRule rule_ = SideRule::kBetween;
  bool has_side_ = false;
  std::vector<PlanarCap> upper_caps_, lower_caps_;
  std::vector<PlanHalf> halves_, silhouette_lines_;
  PlanBox box_;
  double z_low_ = 0, z_high_ = 0;
  double slack_ = 0;
};

}  // namespace diesink
