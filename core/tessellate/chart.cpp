// Sources: the stereographic projection; developable surfaces rolled out; for the paraboloid the
// conformal map of a surface of revolution, whose radius grows as exp of the meridian over r.
// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/chart.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/compound/compound_impl.h"

namespace diesink {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
// Longest triangles of ellipsoids and paraboloids, where letting them grow long along the flatter
// way keeps their number down: regular ones in the chart keep a third of their angle.
constexpr double kStretch = 2.2;
// Normals that point down by no more than rounding still belong to the seen side.
constexpr double kLevel = 1e-12;

// log of the conformal radius of a paraboloid of revolution at slope x.
double log_radius(double x) {
  const double s = std::sqrt(1 + x * x);
  return s + std::log(x / (1 + s));
}

// The edge of a regular triangle of any turn whose deviation is the tolerance, where the square of
// the length across has second derivatives k1 >= k2 >= 0 in the chart: straight one way it deviates
// by k1 d² / 8, round by k d² / 6.
double regular_edge(double k1, double k2, double tolerance) {
  return std::sqrt(tolerance / (k1 / 8 + k2 / 24));
}

// Vertices stand off a face as if the tolerance were no larger than this part of its radius, and as
// if it were no steeper than where its normal rises by this.
constexpr double kCoarse = 0.005, kSteep = 0.25;

// Ellipsoids less long than this take no fewer triangles as spheres: up to 2, measured, none did.
constexpr double kAlmostRound = 2.5;
// Rings about the vertical's image on the sphere and places on each, at which the triangles that a
// drawing takes are counted.
constexpr int kRings = 6, kPlaces = 12;
// Sag of triangles regular on the sphere at most, of its radius.
constexpr double kMostSag = 0.1;
// As spheres in any case where the tolerance is more than this part of their least radius: a
// conformal drawing of such an edge is not to be counted.
constexpr double kSharp = 0.1;
// Turn of the normal over an edge, radians, beyond which a bound along one normal is none.
constexpr double kFar = 0.5;

// A tolerance beyond a good part of the radius says nothing of a triangle's size.
double useful_tolerance(double tolerance, double curvature) {
  return std::fmin(tolerance, 0.25 / curvature);
}

}  // namespace

FaceChart::FaceChart(const CompoundSurface::Impl& surface, Label label,
                     const BaseCurvature* curvature)
    : face_(face_implicit(surface, label)), curvature_(curvature) {
  const CompoundStep& step =
      surface.steps[surface.step_of_row[static_cast<std::size_t>(row_of(label))]];
  side_ = step.solid >= 0 && step.sign == Sign::kMinus ? -1 : 1;
  switch (face_.kind) {
    case Implicit::Kind::kPlane:
      prepare_plane();
      return;
    case Implicit::Kind::kBase: {
      kind_ = Kind::kBase;
      const Machining& m = surface.program.machining;
      face_.c = Vec3(0.5 * (m.x_range[0] + m.x_range[1]), 0.5 * (m.y_range[0] + m.y_range[1]), 0);
      return;
    }
    case Implicit::Kind::kQuadric:
      break;
  }
  const QuadricBody& body =
      std::get<QuadricBody>(surface.bodies[static_cast<std::size_t>(step.solid)].body());
  frame_ = face_.frame;
  axes_ = Vec3(body.A, body.B, body.C);
  mirror_ = side_;
  switch (body.shape) {
    case QuadricShape::kCylinder:
    case QuadricShape::kCone:
      prepare_turning(body);
      return;
    case QuadricShape::kEllipsoid:
      prepare_ellipsoid(body);
      return;
    case QuadricShape::kParaboloid:
      prepare_paraboloid(body);
      return;
  }
}

void FaceChart::prepare_plane() {
  kind_ = Kind::kPlane;
  Vec3 n = side_ * face_.n;
  if (n.z() < 0) n = -n;
  // A level plane keeps x and y to the bit.
  const Vec3 e2 = std::fabs(n.y()) < 0.9 ? Vec3(Vec3::UnitY() - n.y() * n).normalized()
                                         : Vec3(n.cross(Vec3::UnitX() - n.x() * n).normalized());
  frame_.row(0) = e2.cross(n);
  frame_.row(1) = e2;
  frame_.row(2) = n;
}

void FaceChart::prepare_turning(const QuadricBody& body) {
  // The outward normal's height over the turn t is cos t fu + sin t fv (+ fw): largest at its own
  // angle.
  const Vec3 vertical = side_ * frame_.col(2);
  const double fu = vertical.x() / body.A, fv = vertical.y() / body.B;
  const double reach = std::hypot(fu, fv);
  const double start = reach > 0 ? std::atan2(fv, fu) : 0;
  cos_start_ = std::cos(start);
  sin_start_ = std::sin(start);
  if (body.shape == QuadricShape::kCylinder) {
    kind_ = Kind::kCylinder;
    turns_ = TurnTable::ellipse(body.A, body.B, start);
    return;
  }
  kind_ = Kind::kCone;
  turns_ = TurnTable::cone(body.A, body.B, body.C, start);
  slant_ = std::hypot(std::fmax(body.A, body.B), body.C);
  const double total = turns_.last() - turns_.first();
  const double all_around = 2 * std::numbers::pi / total;
  if (vertical.z() / body.C >= reach * (1 - 1e-9)) {
    // Seen all around: the full turn of the cone is a full turn of the chart.
    fan_ = all_around;
    power_ = std::clamp(fan_ / kRulingStretch, 0.5, 2.0);
  } else {
    fan_ = std::fmin(kRulingStretch, all_around);
    power_ = std::clamp(fan_ / kRulingStretch, 0.5, 1.0);
  }
  shift_ = 0.5 * fan_ * (turns_.first() + turns_.last());
  scale_ = slant_ / fan_;
}

void FaceChart::prepare_ellipsoid(const QuadricBody& body) {
  kind_ = Kind::kEllipsoid;
  const Vec3 m = side_ * frame_.col(2).cwiseQuotient(Vec3(body.A, body.B, body.C)).normalized();
  // Principal directions of the map from the sphere about m to the ellipsoid: those of 2 x 2.
  const Vec3 t1 = m.unitOrthogonal(), t2 = m.cross(t1);
  const Vec3 l1 = axes_.cwiseProduct(t1), l2 = axes_.cwiseProduct(t2);
  const double turn = 0.5 * std::atan2(2 * l1.dot(l2), l1.squaredNorm() - l2.squaredNorm());
  const Vec3 e1 = std::cos(turn) * t1 + std::sin(turn) * t2;
  const Vec3 e2 = m.cross(e1);
  sphere_.row(0) = e1;
  sphere_.row(1) = e2;
  sphere_.row(2) = m;
  const double g1 = axes_.cwiseProduct(e1).norm(), g2 = axes_.cwiseProduct(e2).norm();
  // The sphere itself would give the fewest triangles, as long as its directions are uneven.
  const double more = std::sqrt(std::fmax(1, std::fmax(g1, g2) / (std::fmin(g1, g2) * kStretch)));
  const double mean = std::sqrt(g1 * g2);
  stretch_ = g1 > g2 ? Vec2(mean * more, mean / more) : Vec2(mean / more, mean * more);
}

// How many triangles the seen half of an ellipsoid takes as it is drawn, but for a factor.
double FaceChart::triangles_of_ellipsoid(double tolerance) const {
  double sum = 0;
  for (int i = 0; i < kRings; ++i) {
    const double z = (i + 0.5) / kRings;  // rings of one area each
    const double across = std::sqrt(1 - z * z);
    const double factor = 0.5 * (1 + z);
    const double chart_area = stretch_.x() * stretch_.y() / (factor * factor);
    for (int k = 0; k < kPlaces; ++k) {
      const double turn = 2 * std::numbers::pi * k / kPlaces;
      const Vec3 on_sphere =
          sphere_.transpose() * Vec3(across * std::cos(turn), across * std::sin(turn), z);
      const Vec3 p = face_.c + frame_.transpose() * axes_.cwiseProduct(on_sphere);
      const double length = spacing(p, tolerance);
      sum += chart_area / (length * length);
    }
  }
  return sum;
}

void FaceChart::draw_for(double tolerance) {
  if (kind_ != Kind::kEllipsoid) return;
  const double least = axes_.minCoeff(), largest = axes_.maxCoeff();
  if (largest < kAlmostRound * least) return;
  const bool sharp = tolerance * largest >= kSharp * least * least;
  const double conformal = sharp ? kInf : triangles_of_ellipsoid(tolerance);
  const Vec2 stretch = stretch_;
  as_sphere_ = true;
  stretch_ = Vec2(largest, largest);
  if (sharp || triangles_of_ellipsoid(tolerance) < conformal) return;
  as_sphere_ = false;
  stretch_ = stretch;
}

void FaceChart::prepare_paraboloid(const QuadricBody& body) {
  kind_ = Kind::kParaboloid;
  mirror_ = -side_;  // the axes across turn the right way seen from inside
  // Radii across the axis keep triangles as long as the tolerance likes them; where those would be
  // too long the chart grows with the meridian, but not beyond what doubles can hold apart.
  const double deepest = 2 * std::sqrt(body.C) / body.A;
  widening_ = std::fmax(kStretch, deepest / 7);
  steep_ = std::sqrt(widening_ * widening_ - 1);
}

// Angle from the middle of the seen side.
double FaceChart::turn_of(double u, double v) const {
  const double x = u / axes_.x(), y = v / axes_.y();
  return std::atan2(cos_start_ * y - sin_start_ * x, cos_start_ * x + sin_start_ * y);
}

// The point of the rim ellipse at a turn, from the cone's apex.
Vec3 FaceChart::ruling(double turn) const {
  const double c = std::cos(turn), s = std::sin(turn);
  return {axes_.x() * (cos_start_ * c - sin_start_ * s),
          axes_.y() * (sin_start_ * c + cos_start_ * s), -axes_.z()};
}

// Paraboloid: chart radius at a distance r from the axis, and back.
double FaceChart::radius_of(double r) const {
  const double half = 0.5 * axes_.x() * axes_.x();
  const double x = r / half;
  if (x <= steep_) return r;
  return half * steep_ * std::exp((log_radius(x) - log_radius(steep_)) / widening_);
}

double FaceChart::radius_inverse(double radius) const {
  const double half = 0.5 * axes_.x() * axes_.x();
  if (radius <= half * steep_) return radius;
  const double wanted = log_radius(steep_) + widening_ * std::log(radius / (half * steep_));
  double x = std::fmax(steep_, wanted);
  for (int k = 0; k < 20; ++k) {
    const double step = (log_radius(x) - wanted) * x / std::sqrt(1 + x * x);
    x -= step;
    if (std::fabs(step) < 1e-15 * x) break;
  }
  return half * x;
}

Vec2 FaceChart::to_chart(const Vec3& p) const {
  const Vec3 r = p - face_.c;
  if (kind_ == Kind::kBase) return r.head<2>();
  const Vec3 q = frame_ * r;
  switch (kind_) {
    case Kind::kPlane:
    case Kind::kBase:
      break;
    case Kind::kCylinder:
      return {mirror_ * turns_.at(turn_of(q.x(), q.y())), q.z() / kRulingStretch};
    case Kind::kCone: {
      const double slant = q.norm();
      if (slant == 0) return Vec2::Zero();
      const double radius = scale_ * std::pow(slant / slant_, power_);
      const double angle = fan_ * turns_.at(turn_of(q.x(), q.y())) - shift_;
      return {radius * std::cos(angle), mirror_ * radius * std::sin(angle)};
    }
    case Kind::kEllipsoid: {
      const Vec3 s = sphere_ * q.cwiseQuotient(axes_);
      // Points on the sphere to rounding only: the projection of the point beneath it.
      const double away = 1 + s.z() / s.norm();
      const double factor = 2 / (s.norm() * away);
      return {mirror_ * factor * stretch_.x() * s.x(), factor * stretch_.y() * s.y()};
    }
    case Kind::kParaboloid: {
      const double r_across = std::hypot(q.x(), q.y());
      const double factor = r_across > 0 ? radius_of(r_across) / r_across : 1;
      return {factor * q.x(), mirror_ * factor * q.y()};
    }
  }
  return q.head<2>();
}

bool FaceChart::from_chart(const Vec2& c, Vec3& p) const {
  Vec3 q = Vec3::Zero();
  switch (kind_) {
    case Kind::kPlane:
      p = face_.c + frame_.transpose() * Vec3(c.x(), c.y(), 0);
      return true;
    case Kind::kBase: {
      p = face_.c + Vec3(c.x(), c.y(), 0);
      BaseHit hit;
      if (!face_.surface->base_at(p.x(), p.y(), hit)) return false;
      p.z() = hit.z;
      return true;
    }
    case Kind::kCylinder: {
      const double s = mirror_ * c.x();
      if (!(s >= turns_.first() && s <= turns_.last())) return false;
      q = ruling(turns_.inverse(s));
      q.z() = c.y() * kRulingStretch;
      break;
    }
    case Kind::kCone: {
      const double radius = c.norm();
      const double angle = (std::atan2(mirror_ * c.y(), c.x()) + shift_) / fan_;
      if (!(angle >= turns_.first() && angle <= turns_.last())) return false;
      q = ruling(turns_.inverse(angle));
      q *= slant_ * std::pow(radius / scale_, 1 / power_) / q.norm();
      break;
    }
    case Kind::kEllipsoid: {
      const double x = mirror_ * c.x() / stretch_.x(), y = c.y() / stretch_.y();
      const double square = x * x + y * y;
      const Vec3 s = Vec3(4 * x, 4 * y, 4 - square) / (4 + square);
      q = axes_.cwiseProduct(sphere_.transpose() * s);
      break;
    }
    case Kind::kParaboloid: {
      const double radius = c.norm();
      const double r_across = radius_inverse(radius);
      const double factor = radius > 0 ? r_across / radius : 1;
      const double depth = r_across / axes_.x();
      q = Vec3(factor * c.x(), mirror_ * factor * c.y(), depth * depth);
      break;
    }
  }
  p = face_.c + frame_.transpose() * q;
  Vec3 gradient;
  face_.form(p, gradient);
  return side_ * gradient.z() >= -kLevel * gradient.norm();
}

double FaceChart::spacing(const Vec3& p, double tolerance) const {
  if (kind_ == Kind::kPlane) return kInf;
  if (kind_ == Kind::kBase) return base_spacing(p, tolerance);
  const Vec3 q = frame_ * (p - face_.c);
  switch (kind_) {
    case Kind::kPlane:
    case Kind::kBase:
      break;
    case Kind::kCylinder: {
      const double rate = turns_.rate(turn_of(q.x(), q.y()));
      const double curvature = axes_.x() * axes_.y() / (rate * rate * rate);
      return regular_edge(curvature, 0, useful_tolerance(tolerance, curvature));
    }
    case Kind::kCone: {
      // Curvature across the ruling is a constant of the ruling over the slant length.
      const double turn = turn_of(q.x(), q.y());
      const Vec3 rim = ruling(turn);
      const Vec3 gradient(rim.x() / (axes_.x() * axes_.x()), rim.y() / (axes_.y() * axes_.y()),
                          1 / axes_.z());
      const double length = rim.norm(), rate = turns_.rate(turn);
      // The form of d rim / d turn is 1; its part across the ruling is rate * length long.
      const double shape = length / (gradient.norm() * rate * rate * length * length);
      const double t = tolerance;
      // At the apex itself: what the nearest ring of triangles allows.
      const double slant = std::fmax(q.norm(), 8 * t * fan_ * fan_ / shape);
      const double curvature = shape / slant;
      const double radius = scale_ * std::pow(slant / slant_, power_);
      return regular_edge(curvature, 0, useful_tolerance(t, curvature)) * radius * fan_ / slant;
    }
    case Kind::kEllipsoid: {
      const Vec3 s = sphere_ * q.cwiseQuotient(axes_);
      const double steep = q.cwiseQuotient(axes_.cwiseProduct(axes_)).norm();
      const double factor = 0.5 * (1 + s.z());  // sphere length a unit of the unscaled chart
      if (as_sphere_) {
        // What the sphere sags by, as long as the tangent plane is far from the centre; where that
        // triangle's normals turn far it is only bounded on the way from the centre.
        double sag = tolerance * steep;
        if (std::sqrt(6 * sag) > kFar * axes_.minCoeff() * steep) sag = tolerance / q.norm();
        sag = std::fmin(sag, kMostSag);
        return std::sqrt(6 * sag) * stretch_.x() / factor;
      }
      const double curvature = factor * factor / steep;
      const double smallest = std::fmin(stretch_.x(), stretch_.y()),
                   largest = std::fmax(stretch_.x(), stretch_.y());
      const double least_axis = axes_.minCoeff();
      return regular_edge(curvature / (smallest * smallest), curvature / (largest * largest),
                          useful_tolerance(tolerance, 1 / (least_axis * least_axis * steep)));
    }
    case Kind::kParaboloid: {
      const double r_across = std::hypot(q.x(), q.y());
      const double half = 0.5 * axes_.x() * axes_.x();
      const double x = r_across / half;
      const double curvature = 1 / (half * std::sqrt(1 + x * x));
      double around = 1, along = 1;  // chart length over length across the axis
      if (x > steep_) {
        around = radius_of(r_across) / r_across;
        along = around * std::sqrt(1 + x * x) / widening_;
      }
      const double k_around = curvature / (around * around), k_along = curvature / (along * along);
      return regular_edge(std::fmax(k_around, k_along), std::fmin(k_around, k_along),
                          useful_tolerance(tolerance, curvature));
    }
  }
  return kInf;
}

double FaceChart::base_spacing(const Vec3& p, double tolerance) const {
  Range zxx, zxy, zyy, zx, zy;
  const FergusonSurface* ferguson = std::get_if<FergusonSurface>(&face_.surface->base);
  if (!ferguson) return kInf;
  const PlanBox point{p.x(), p.x(), p.y(), p.y()};
  if (curvature_) {
    BaseShape shape;
    if (!curvature_->over(point, shape)) return kInf;
    zx = shape.zx, zy = shape.zy;
    zxx = shape.zxx, zxy = shape.zxy, zyy = shape.zyy;
  } else {
    const BaseBounds b = ferguson->bounds(point);
    if (b.coverage == Coverage::kOutside) return kInf;
    zx = b.zx, zy = b.zy;
    zxx = b.zxx, zxy = b.zxy, zyy = b.zyy;
  }
  const auto middle = [](const Range& r) { return 0.5 * (r.lo + r.hi); };
  const auto half = [](const Range& r) { return 0.5 * (r.hi - r.lo); };
  // Eigenvalues of the middle, larger by how much it varies.
  const double mean = 0.5 * (middle(zxx) + middle(zyy));
  const double apart = std::hypot(0.5 * (middle(zxx) - middle(zyy)), middle(zxy));
  const double more = std::hypot(half(zxx), half(zxy), half(zyy));
  const double steep = std::hypot(1.0, middle(zx), middle(zy));
  const double k1 = (std::fabs(mean) + apart + more) / steep;
  const double k2 = std::fabs(std::fabs(mean) - apart) / steep;
  if (!(k1 > 0)) return kInf;
  return regular_edge(k1, std::fmin(k1, k2), tolerance);
}

double FaceChart::stand_off(double part, double tolerance, Vec3& p) const {
  assert(bends_every_way());
  double curvature = 2 / (axes_.x() * axes_.x());  // the largest: of a paraboloid, at its vertex
  if (kind_ == Kind::kEllipsoid) {
    const Vec3 q = frame_ * (p - face_.c);
    const double least = axes_.minCoeff();
    curvature = 1 / (least * least * q.cwiseQuotient(axes_.cwiseProduct(axes_)).norm());
  }
  const double off = part * std::fmin(tolerance, kCoarse / curvature);
  const double up = normal(p).z(), least = std::fmax(up, kSteep);
  p.z() += side_ * off / least;
  return off * up / least;
}

Vec3 FaceChart::normal(const Vec3& p) const {
  if (kind_ == Kind::kPlane) return frame_.row(2);
  Vec3 n;
  face_.form(p, n);
  const double length = n.norm();
  if (length > 0) return side_ * n / length;
  const Vec3 axis = face_.frame.row(2);  // the apex of a cone
  return axis.z() < 0 ? Vec3(-axis) : axis;
}

std::optional<double> FaceChart::turn(const Vec3& p) const {
  if (!has_rulings()) return std::nullopt;
  const Vec3 q = frame_ * (p - face_.c);
  if (kind_ == Kind::kCone && q.norm() == 0) return std::nullopt;
  return mirror_ * turns_.at(turn_of(q.x(), q.y()));
}

std::optional<Vec3> FaceChart::apex() const {
  if (kind_ != Kind::kCone) return std::nullopt;
  return face_.c;
}

}  // namespace diesink
