// Vertical lines against convex bodies. Source: Choi et al. 1988, equations (7) to (10); roots
// after the usual stable form of the quadratic (no difference of nearly equal numbers).
// SPDX-License-Identifier: Apache-2.0
#include "core/compound/body_line.h"

#include <algorithm>
#include <cmath>

namespace diesink {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
// A face or axis closer to upright than this (sine of its angle) is upright: over a body of any
// size it leans by less than the tie tolerance.
constexpr double kUpright = 1e-13;

// Roots of q2 t² + 2 q1 t + q0 with the discriminant given, lower first. Infinite where q2 is zero.
inline void roots(double q2, double q1, double q0, double disc, double& first, double& last) {
  const double s = std::sqrt(disc);
  const double m = q1 >= 0 ? q1 + s : q1 - s;
  const double far = -m / q2;                       // of larger magnitude
  const double near = m != 0 ? -q0 / m : -q1 / q2;  // m = 0: double root at the centre
  first = std::fmin(far, near);
  last = std::fmax(far, near);
}

}  // namespace

BodyLine::BodyLine(const Body& body, double slack) : body_(&body), slack_(slack) {
  const std::array<Vec3, 2> box = bounds_of(body);
  box_ = {box[0].x() - slack, box[1].x() + slack, box[0].y() - slack, box[1].y() + slack};
  z_low_ = box[0].z();
  z_high_ = box[1].z();
  if (const Polyhedron* polyhedron = std::get_if<Polyhedron>(&body)) {
    prepare(*polyhedron);
  } else {
    prepare(std::get<QuadricBody>(body));
  }
}

void BodyLine::prepare(const Polyhedron& body) {
  side_.cx = 0.5 * (box_.x0 + box_.x1);
  side_.cy = 0.5 * (box_.y0 + box_.y1);
  const Vec3 centre(side_.cx, side_.cy, 0);
  double off = 0;  // how far corners lie off their faces, of coordinates that are rounded
  for (const PolyhedronFace& face : body.faces) {
    const Plane& plane = face.plane;
    for (const std::uint8_t v : face.loop) {
      off = std::fmax(off, std::fabs(plane.n.dot(body.vertices[v] - body.vertices[face.loop[0]])));
    }
    // The plane about the body's own centre: distance of a vertex of the face, not of the far
    // origin.
    const Vec3 corner = body.vertices[face.loop[0]] - centre;
    const double d = -plane.n.dot(corner);
    if (std::fabs(plane.n.z()) < kUpright) {
      halves_.push_back({plane.n.x(), plane.n.y(), d, face.number});
      continue;
    }
    PlanarCap cap;
    cap.zx = -plane.n.x() / plane.n.z();
    cap.zy = -plane.n.y() / plane.n.z();
    cap.z0 = -d / plane.n.z();
    cap.face = face.number;
    (plane.n.z() > 0 ? upper_caps_ : lower_caps_).push_back(cap);
  }
  // The planes meet a little beyond the corners; a height cut off there would be on none of them.
  constexpr double kMeetBeyond = 8;  // where they do so at some seven degrees
  z_low_ -= kMeetBeyond * off;
  z_high_ += kMeetBeyond * off;
}

void BodyLine::prepare(const QuadricBody& body) {
  has_side_ = true;
  const Vec3 n = body.frame.row(0), o = body.frame.row(1), a = body.frame.row(2);
  // Centre of the quadric: apex of a cone, else p. In coordinates about it q has no linear part,
  // except a paraboloid.
  const Vec3 centre = body.shape == QuadricShape::kCone ? Vec3(body.p + body.C * a) : body.p;
  side_.cx = centre.x();
  side_.cy = centre.y();
  side_.cz = centre.z();
  Mat3 q = n * n.transpose() / (body.A * body.A) + o * o.transpose() / (body.B * body.B);
  Vec3 linear = Vec3::Zero();  // q = r'Qr + 2 linear'r + constant
  double constant = 0;
  switch (body.shape) {
    case QuadricShape::kEllipsoid:
      q += a * a.transpose() / (body.C * body.C);
      constant = -1;
      break;
    case QuadricShape::kCylinder:
      constant = -1;
      break;
    case QuadricShape::kCone:
      q -= a * a.transpose() / (body.C * body.C);
      break;
    case QuadricShape::kParaboloid:
      linear = -0.5 * a;
      break;
  }
  const double norm = 1 / (body.A * body.A) + 1 / (body.B * body.B) +
                      (body.shape == QuadricShape::kCone ? 1 / (body.C * body.C) : 0.0);
  SideQuadratic& s = side_;
  s.q2 = q(2, 2);
  s.bx = q(0, 2);
  s.by = q(1, 2);
  s.b0 = linear.z();
  s.c0 = constant;
  s.cx1 = 2 * linear.x();
  s.cy1 = 2 * linear.y();
  s.cxx = q(0, 0);
  s.cxy = 2 * q(0, 1);
  s.cyy = q(1, 1);
  const bool upright_axis = std::hypot(a.x(), a.y()) < kUpright;
  if (body.shape == QuadricShape::kCylinder && upright_axis) {
    rule_ = SideRule::kColumn;
    s.q2 = s.bx = s.by = 0;
    s.disc_slack = 2 * slack_ * std::fmax(1 / body.A, 1 / body.B);
  } else {
    if (body.shape == QuadricShape::kParaboloid && upright_axis) s.q2 = s.bx = s.by = 0;
    // Minors by their closed forms: exact zeros stay zero and an ellipsoid's silhouette does not
    // cancel.
    const auto minor = [&](int i, int j, int k, int l) {
      return q(i, j) * q(k, l) - q(i, l) * q(k, j);
    };
    s.dxx = -minor(0, 0, 2, 2);
    s.dyy = -minor(1, 1, 2, 2);
    s.dxy = 2 * (q(0, 2) * q(1, 2) - q(0, 1) * q(2, 2));
    if (body.shape == QuadricShape::kCylinder) {
      // Rank one: the square of one linear form over the plan, with the sign of a strip.
      // The determinant of a rank-two form's 2x2 minors is the adjugate: (a a') / (A B)².
      const double k = 1 / (body.A * body.A * body.B * body.B);
      s.dxx = -k * a.y() * a.y();
      s.dyy = -k * a.x() * a.x();
      s.dxy = 2 * k * a.x() * a.y();
    }
    s.d0 = s.b0 * s.b0 - s.q2 * s.c0;
    s.dx1 = 2 * s.b0 * s.bx - s.q2 * s.cx1;
    s.dy1 = 2 * s.b0 * s.by - s.q2 * s.cy1;
    if (body.shape == QuadricShape::kCone && s.q2 < 0) {
      rule_ = a.z() > 0 ? SideRule::kBelowFirst : SideRule::kAboveLast;
    } else if (body.shape == QuadricShape::kCone && s.q2 < 1e-14 * norm) {
      // A generator of the cone is upright: the far root is at infinity on the other nappe's side.
      s.q2 = 0;
      rule_ = a.z() > 0 ? SideRule::kBelowFirst : SideRule::kAboveLast;
    }
    // What the discriminant falls by over the slack beside the silhouette. Of an ellipse or strip
    // about the origin its slope there is 2 sqrt(d0 times the larger eigenvalue) at most, which it
    // has along a cylinder's lines and at the short axis of an ellipsoid's shadow.
    const double reach = std::fmax(std::fmax(box_.x1 - box_.x0, box_.y1 - box_.y0), slack_);
    if (body.shape == QuadricShape::kCylinder || body.shape == QuadricShape::kEllipsoid) {
      const double larger = -0.5 * (s.dxx + s.dyy) + std::hypot(0.5 * (s.dxx - s.dyy), 0.5 * s.dxy);
      s.disc_slack = slack_ * 2 * std::sqrt(larger * s.d0);
    } else {
      s.disc_slack =
          slack_ * (2 * (std::fabs(s.dxx) + std::fabs(s.dxy) + std::fabs(s.dyy)) * reach +
                    std::fabs(s.dx1) + std::fabs(s.dy1));
    }
    if (body.shape == QuadricShape::kCone)
      s.disc_slack = std::fmin(s.disc_slack, slack_ * slack_ * norm * norm * reach);
    if (body.shape == QuadricShape::kCone && s.q2 == 0) {
      // The line through the apex along which q1 is nothing: beyond it lines meet the mirrored
      // nappe alone, on it the apex at most.
      const double outward = (rule_ == SideRule::kBelowFirst ? -1 : 1) / std::hypot(s.bx, s.by);
      halves_.push_back({outward * s.bx, outward * s.by, 0, kFaceSide});
      s.disc_slack = slack_ * slack_ * norm;  // of q0, where a line touches the apex
    }
  }
  if (body.shape == QuadricShape::kCone && rule_ == SideRule::kBetween) {
    // Both roots lie on one nappe, and with them their middle: the body's own is where that is not
    // beyond the apex. A line behind the apex meets the mirrored nappe alone.
    const double hx = a.x() - a.z() * s.bx / s.q2, hy = a.y() - a.z() * s.by / s.q2;
    const double length = std::hypot(hx, hy);
    if (length > 0) halves_.push_back({hx / length, hy / length, 0, kFaceSide});
  }
  prepare_silhouette_lines(body);
  if (body.shape == QuadricShape::kEllipsoid) return;

  // Caps: planes a·(r - p) = 0 and = C.
  const bool has_bottom = body.shape != QuadricShape::kParaboloid;
  const bool has_top = body.shape != QuadricShape::kCone;
  const auto add_cap = [&](double w, double outward, std::uint8_t face) {
    // outward * (a·(r - p) - w) <= 0 inside; about (cx, cy).
    const Vec3 on = body.p + w * a - Vec3(s.cx, s.cy, 0);
    if (std::fabs(a.z()) < kUpright) {
      halves_.push_back(
          {outward * a.x(), outward * a.y(), -outward * (a.x() * on.x() + a.y() * on.y()), face});
      return;
    }
    PlanarCap cap;
    cap.zx = -a.x() / a.z();
    cap.zy = -a.y() / a.z();
    cap.z0 = on.z() - cap.zx * on.x() - cap.zy * on.y();
    cap.face = face;
    (outward * a.z() > 0 ? upper_caps_ : lower_caps_).push_back(cap);
  };
  if (has_bottom) add_cap(0, -1, kFaceBottom);
  if (has_top) add_cap(body.C, 1, kFaceTop);
}

// The discriminant of a cylinder or cone is a product of two linear functions of the plan.
void BodyLine::prepare_silhouette_lines(const QuadricBody& body) {
  const SideQuadratic& s = side_;
  if (rule_ != SideRule::kBetween || !(s.q2 > 0)) return;
  const Vec3 a = body.frame.row(2);
  if (body.shape == QuadricShape::kCylinder) {
    // disc = q2 - k (a.y dx - a.x dy)²
    const double m = 1 / (body.A * body.B), h = std::sqrt(s.q2);
    silhouette_lines_ = {{m * a.y(), -m * a.x(), -h, kFaceSide},
                         {-m * a.y(), m * a.x(), -h, kFaceSide}};
  } else if (body.shape == QuadricShape::kCone) {
    // disc = p² - r² along its principal axes; the body lies where p > 0.
    const double mean = 0.5 * (s.dxx + s.dyy),
                 turn = std::hypot(0.5 * (s.dxx - s.dyy), 0.5 * s.dxy);
    const double big = mean + turn, small = mean - turn;
    if (!(big > 0) || !(small < 0)) return;
    const double angle = 0.5 * std::atan2(s.dxy, s.dxx - s.dyy);
    double px = std::cos(angle), py = std::sin(angle);
    if (px * a.x() + py * a.y() > 0) px = -px, py = -py;
    const double p = std::sqrt(big), r = std::sqrt(-small);
    silhouette_lines_ = {{-(p * px - r * -py), -(p * py - r * px), 0, kFaceSide},
                         {-(p * px + r * -py), -(p * py + r * px), 0, kFaceSide}};
  }
}

bool BodyLine::meet(double x, double y, LineHit& hit) const {
  if (!(x >= box_.x0 && x <= box_.x1 && y >= box_.y0 && y <= box_.y1)) return false;
  const double dx = x - side_.cx, dy = y - side_.cy;
  for (const PlanHalf& h : halves_) {
    if (h.a * dx + h.b * dy + h.c > slack_) return false;
  }
  double lower = -kInf, upper = kInf;
  std::uint8_t lower_face = 0, upper_face = 0;
  if (has_side_) {
    const SideQuadratic& s = side_;
    const double q0 = s.c0 + dx * (s.cx1 + s.cxx * dx + s.cxy * dy) + dy * (s.cy1 + s.cyy * dy);
    if (rule_ == SideRule::kColumn) {
      if (q0 > s.disc_slack) return false;
    } else {
      double disc = s.d0 + dx * (s.dx1 + s.dxx * dx + s.dxy * dy) + dy * (s.dy1 + s.dyy * dy);
      if (disc < 0) {
        if (disc < -s.disc_slack && rule_ == SideRule::kBetween) return false;
        disc = 0;
      }
      const double q1 = s.b0 + s.bx * dx + s.by * dy;
      double first, last;
      roots(s.q2, q1, q0, disc, first, last);
      switch (rule_) {
        case SideRule::kBelowFirst:
          if (s.q2 == 0) first = q1 > 0 ? -q0 / (2 * q1) : q0 > s.disc_slack ? -kInf : 0;
          last = first;
          first = -kInf;
          break;
        case SideRule::kAboveLast:
          if (s.q2 == 0) last = q1 < 0 ? -q0 / (2 * q1) : q0 > s.disc_slack ? kInf : 0;
          first = last;
          last = kInf;
          break;
        case SideRule::kBetween:
          if (s.q2 == 0) {  // an upright paraboloid: one root, open towards its axis
            const double root = -q0 / (2 * s.b0);
            first = s.b0 < 0 ? root : -kInf;
            last = s.b0 < 0 ? kInf : root;
          }
          break;
        case SideRule::kColumn:
          break;
      }
      lower = side_.cz + first;
      upper = side_.cz + last;
      lower_face = upper_face = kFaceSide;
    }
  }
  for (const PlanarCap& c : upper_caps_) {
    const double z = c.z0 + c.zx * dx + c.zy * dy;
    if (z < upper) {
      upper = z;
      upper_face = c.face;
    }
  }
  for (const PlanarCap& c : lower_caps_) {
    const double z = c.z0 + c.zx * dx + c.zy * dy;
    if (z > lower) {
      lower = z;
      lower_face = c.face;
    }
  }
  // A line beside a sharp edge by less than the slack still touches: the slack times the steepest
  // slope there is not known, the height gap of a miss within the slack is bounded by it for edges
  // up to 45 degrees.
  if (lower > upper + slack_) return false;
  hit.lower = std::clamp(lower, z_low_, z_high_);
  hit.upper = std::clamp(upper, z_low_, z_high_);
  hit.lower_face = lower_face;
  hit.upper_face = upper_face;
  return true;
}

bool BodyLine::face_height(std::uint8_t face, bool upper, double x, double y, double& z) const {
  const double dx = x - side_.cx, dy = y - side_.cy;
  if (has_side_ && face == kFaceSide) {
    const SideQuadratic& s = side_;
    if (rule_ == SideRule::kColumn) return false;
    const double q0 = s.c0 + dx * (s.cx1 + s.cxx * dx + s.cxy * dy) + dy * (s.cy1 + s.cyy * dy);
    const double disc = s.d0 + dx * (s.dx1 + s.dxx * dx + s.dxy * dy) + dy * (s.dy1 + s.dyy * dy);
    if (disc < -s.disc_slack && s.q2 != 0) return false;
    const double q1 = s.b0 + s.bx * dx + s.by * dy;
    if (s.q2 == 0) {
      if (q1 == 0) return false;
      z = s.cz - q0 / (2 * q1);
      return true;
    }
    double first, last;
    roots(s.q2, q1, q0, std::fmax(disc, 0), first, last);
    const bool take_last = rule_ == SideRule::kBetween ? upper : rule_ == SideRule::kAboveLast;
    z = s.cz + (take_last ? last : first);
    return true;
  }
  for (const PlanarCap& c : upper ? upper_caps_ : lower_caps_) {
    if (c.face == face) {
      z = c.z0 + c.zx * dx + c.zy * dy;
      return true;
    }
  }
  return false;
}

Vec3 BodyLine::normal(std::uint8_t face, const Vec3& point) const {
  if (const Polyhedron* polyhedron = std::get_if<Polyhedron>(body_)) {
    for (const PolyhedronFace& f : polyhedron->faces) {
      if (f.number == face) return f.plane.n;
    }
    return Vec3::UnitZ();
  }
  const QuadricBody& b = std::get<QuadricBody>(*body_);
  Vec3 a = b.frame.row(2);
  if (face == kFaceBottom) return -a;
  if (face == kFaceTop) return a;
  const Vec3 l = b.frame * (point - b.p);
  Vec3 g(l.x() / (b.A * b.A), l.y() / (b.B * b.B), 0);
  switch (b.shape) {
    case QuadricShape::kEllipsoid:
      g.z() = l.z() / (b.C * b.C);
      break;
    case QuadricShape::kCone:
      g.z() = (1 - l.z() / b.C) / b.C;
      break;
    case QuadricShape::kParaboloid:
      g.z() = -0.5;
      break;
    case QuadricShape::kCylinder:
      break;
  }
  const double length = g.norm();
  if (!(length > 0)) return b.shape == QuadricShape::kCone ? a : Vec3::UnitZ();  // the apex
  return b.frame.transpose() * (g / length);
}

}  // namespace diesink
