// Sources: the value of a quadratic form between vertices on its zero set, -sum l_i l_j
// (v_i - v_j)'A(v_i - v_j); copositive matrices of order three after Hadeler, Linear Algebra Appl.
// 49, 1983; the remainder of linear interpolation.
// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/deviation.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/compound/compound_impl.h"
#include "core/tessellate/deviation_forms.h"

namespace diesink {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
// What coordinates computed in doubles are off by, relative to the largest.
constexpr double kRounding = 1e-15;
// A bound is worth refining where the gradient varies by more than this over the triangle.
constexpr double kUneven = 0.97;

double coordinate_rounding(const Vec3& a, const Vec3& b) {
  return kRounding * std::fmax(a.cwiseAbs().maxCoeff(), b.cwiseAbs().maxCoeff());
}

// True where sum l_i l_j q_ij <= sum l_i m_i for all l in the triangle.
bool stays_below(const EdgeForms& q, const std::array<double, 3>& m) {
  if (m[0] < 0 || m[1] < 0 || m[2] < 0) return false;
  // With P_ii = m_i and P_ij = (m_i + m_j - q_ij) / 2 this is l'Pl >= 0.
  const double p01 = 0.5 * (m[0] + m[1] - q[2]), p02 = 0.5 * (m[0] + m[2] - q[1]),
               p12 = 0.5 * (m[1] + m[2] - q[0]);
  const double s0 = std::sqrt(m[0]), s1 = std::sqrt(m[1]), s2 = std::sqrt(m[2]);
  const double t01 = p01 + s0 * s1, t02 = p02 + s0 * s2, t12 = p12 + s1 * s2;
  if (t01 < 0 || t02 < 0 || t12 < 0) return false;
  return s0 * s1 * s2 + p01 * s2 + p02 * s1 + p12 * s0 + std::sqrt(2 * t01 * t02 * t12) >= 0;
}

// Smallest h, to a percent and never too small, with sum l_i l_j q_ij + sum l_i p_i <=
// h sum l_i g_i on the triangle. Needs: all g_i > 0, the left side above 0 somewhere.
double largest_ratio(const EdgeForms& q, const std::array<double, 3>& g, const VertexValues& p) {
  const double most = largest_between(q, p);
  double hi = most / std::min({g[0], g[1], g[2]});
  const double greatest = std::max({g[0], g[1], g[2]});
  if (hi * greatest * kUneven <= most) return hi;
  double lo = most / greatest;
  for (int k = 0; k < 12 && hi - lo > 0.005 * hi; ++k) {
    const double h = 0.5 * (lo + hi);
    const bool enough = stays_below(q, {h * g[0] - p[0], h * g[1] - p[1], h * g[2] - p[2]});
    (enough ? hi : lo) = h;
  }
  return hi;
}

// How far one must go from the triangle along a unit direction m to reach the quadric: with g the
// slope of F along m at the vertices and `curve` = m'Am, F(x + h m) = F(x) + h g(x) + h² curve,
// where F(x) is what the edges' forms and its values at the vertices make of it.
double reach_along(const EdgeForms& q, const std::array<double, 3>& g, double curve,
                   const VertexValues& values) {
  const double least = std::min({g[0], g[1], g[2]}), greatest = std::max({g[0], g[1], g[2]});
  if (!(least > 0)) return kInf;
  double reach = 0;
  for (const double sign : {1.0, -1.0}) {
    const EdgeForms form{sign * q[0], sign * q[1], sign * q[2]};
    const VertexValues ends{-sign * values[0], -sign * values[1], -sign * values[2]};
    const double most = largest_between(form, ends);
    if (most <= 0) continue;
    const double c = sign * curve;
    const double disc = least * least + 4 * c * most;
    double h = disc >= 0 ? 2 * most / (least + std::sqrt(disc)) : kInf;
    if (least < kUneven * greatest) {
      // Where F is largest g need not be least.
      double uneven = largest_ratio(form, g, ends);
      if (c < 0) {  // g is less by |c| h on the way: grown until it covers itself
        double next = uneven;
        bool settled = false;
        for (int k = 0; k < 8 && !settled; ++k) {
          uneven = 1.001 * next;
          const double less = c * uneven;
          if (!(least + less > 0)) break;
          next = largest_ratio(form, {g[0] + less, g[1] + less, g[2] + less}, ends);
          settled = next <= uneven;
        }
        if (!settled) uneven = kInf;
      }
      h = std::fmin(h, uneven);
    }
    reach = std::fmax(reach, h);
  }
  return reach;
}

// Of an ellipsoid, however sharp its edges: on the way from the centre through each point of the
// triangle, r, it is reached at r over its norm, the root of the form and 1.
double from_centre(const Implicit& f, const EdgeForms& q, const VertexValues& values,
                   const std::array<Vec3, 3>& v) {
  const double longest = f.k.minCoeff(), thinnest = f.k.maxCoeff();  // squares, of 1 over the axis
  constexpr double kLong = kLongEllipsoid * kLongEllipsoid * (1 + 1e-9);  // by more than rounding
  if (!(f.m < 0 && f.l == 0 && longest > 0 && thinnest >= kLong * longest)) return kInf;
  const double inside = largest_between(q, {-values[0], -values[1], -values[2]}) / -f.m;
  const double outside = largest_between({-q[0], -q[1], -q[2]}, values) / -f.m;
  if (!(inside < 1)) return kInf;
  double farthest = 0;
  for (const Vec3& p : v) farthest = std::fmax(farthest, (p - f.c).norm());
  // (1 / sqrt(1 - s) - 1 and 1 - 1 / sqrt(1 + s), without cancelling.)
  const double in = std::sqrt(1 - std::fmax(0, inside)), out = std::sqrt(1 + std::fmax(0, outside));
  return farthest * std::fmax(std::fmax(0, inside) / (in * (1 + in)),
                              std::fmax(0, outside) / (out * (1 + out)));
}

double over_quadric(const Implicit& f, const Vec3& a, const Vec3& b, const Vec3& c) {
  const std::array<Vec3, 3> v{a, b, c};
  std::array<Vec3, 3> gradient;
  VertexValues values{};
  double steepest = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    values[i] = f.form(v[i], gradient[i]);
    steepest = std::fmax(steepest, gradient[i].squaredNorm());
  }
  steepest = std::sqrt(steepest);
  const auto form = [&f](const Vec3& e) {
    const Vec3 l = f.frame * e;
    return f.k.dot(l.cwiseProduct(l));
  };
  EdgeForms q{form(c - b), form(a - c), form(b - a)};
  const auto along = [&](const Vec3& m) {
    std::array<double, 3> g{gradient[0].dot(m), gradient[1].dot(m), gradient[2].dot(m)};
    // At the apex of a cone the gradient vanishes; the triangle and the cone between its edges are
    // rays from there, so that the opposite edge is as far off as any point.
    EdgeForms edges = q;
    for (std::size_t i = 0; i < 3; ++i) {
      if (gradient[i].norm() > 1e-9 * steepest) continue;
      const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
      edges[j] = edges[k] = 0;
      g[i] = std::fmin(g[j], g[k]);
    }
    return reach_along(edges, g, form(m), values);
  };
  Vec3 n = (b - a).cross(c - a);
  const double area = n.norm();
  double reach = kInf;
  if (area > 0) {
    n /= area;
    if (n.dot(gradient[0] + gradient[1] + gradient[2]) < 0) n = -n;
    reach = along(n);
    const double least = std::min({n.dot(gradient[0]), n.dot(gradient[1]), n.dot(gradient[2])});
    if (least > 0.9 * steepest) return reach;
  }
  reach = std::fmin(reach, from_centre(f, q, values, v));
  // A sliver may stand across its surface: go along the surface's own normal instead.
  const Vec3 m = gradient[0] + gradient[1] + gradient[2];
  const double length = m.norm();
  return length > 0 ? std::fmin(reach, along(m / length)) : reach;
}

double over_plane(const Implicit& f, const Vec3& a, const Vec3& b, const Vec3& c) {
  return std::fmax(std::fabs(f.n.dot(a - f.c)),
                   std::fmax(std::fabs(f.n.dot(b - f.c)), std::fabs(f.n.dot(c - f.c))));
}

double middle(const Range& r) { return 0.5 * (r.lo + r.hi); }
double half(const Range& r) { return 0.5 * (r.hi - r.lo); }

// Norm of the symmetric matrix of second derivatives.
double frobenius(double xx, double xy, double yy) {
  return std::sqrt(xx * xx + 2 * xy * xy + yy * yy);
}

}  // namespace

TriangleDeviation::TriangleDeviation(const CompoundSurface::Impl& surface) : surface_(&surface) {
  for (const BodyLine& body : surface.bodies) {
    sides_.push_back(body.has_side() ? face_implicit(body, kFaceSide) : Implicit{});
  }
  if (const FergusonSurface* ferguson = std::get_if<FergusonSurface>(&surface.base)) {
    base_.emplace(*ferguson);
    if (ferguson->affine()) affine_.emplace(*ferguson);
  }
}

Implicit TriangleDeviation::face(Label label) const {
  const std::int32_t solid =
      surface_->steps[surface_->step_of_row[static_cast<std::size_t>(row_of(label))]].solid;
  return solid >= 0 && face_of(label) == kFaceSide &&
                 sides_[static_cast<std::size_t>(solid)].kind == Implicit::Kind::kQuadric
             ? sides_[static_cast<std::size_t>(solid)]
             : face_implicit(*surface_, label);
}

double TriangleDeviation::operator()(Label label, const Vec3& a, const Vec3& b,
                                     const Vec3& c) const {
  const double rounding = std::fmax(coordinate_rounding(a, b), coordinate_rounding(b, c));
  const std::int32_t solid =
      surface_->steps[surface_->step_of_row[static_cast<std::size_t>(row_of(label))]].solid;
  if (solid < 0) {
    if (base_) return over_base(a, b, c) + rounding;
  } else if (const Implicit& side = sides_[static_cast<std::size_t>(solid)];
             face_of(label) == kFaceSide && side.kind == Implicit::Kind::kQuadric) {
    return over_quadric(side, a, b, c) + rounding;
  }
  const Implicit plane = face_implicit(*surface_, label);
  if (plane.kind != Implicit::Kind::kPlane) return kInf;
  return over_plane(plane, a, b, c) + rounding;
}

// By the lattice of second derivatives: the height differs from the interpolant by half the mean
// over the vertices of the second derivative towards each, whose middle gives the form of the edges
// and whose spread their lengths.
bool TriangleDeviation::base_gap(const PlanBox& box, const Vec3& a, const Vec3& b, const Vec3& c,
                                 BaseGap& out) const {
  BaseShape shape;
  if (!base_->over(box, shape)) return false;
  const double hxx = middle(shape.zxx), hxy = middle(shape.zxy), hyy = middle(shape.zyy);
  const double spread = frobenius(half(shape.zxx), half(shape.zxy), half(shape.zyy));
  if (!std::isfinite(spread)) return false;
  const std::array<Vec3, 3> edge{c - b, a - c, b - a};
  EdgeForms above, below;
  for (std::size_t i = 0; i < 3; ++i) {
    const double x = edge[i].x(), y = edge[i].y();
    const double form = hxx * x * x + 2 * hxy * x * y + hyy * y * y;
    const double varying = spread * (x * x + y * y);
    above[i] = 0.5 * (varying + form);
    below[i] = 0.5 * (varying - form);
  }
  out.gap = std::fmax(largest_between(above), largest_between(below));
  out.bend = frobenius(hxx, hxy, hyy) + spread;
  out.slope = Vec2(middle(shape.zx), middle(shape.zy));
  out.slope_spread = std::hypot(half(shape.zx), half(shape.zy));
  return true;
}

double TriangleDeviation::over_base(const Vec3& a, const Vec3& b, const Vec3& c) const {
  PlanBox box{std::min({a.x(), b.x(), c.x()}), std::max({a.x(), b.x(), c.x()}),
              std::min({a.y(), b.y(), c.y()}), std::max({a.y(), b.y(), c.y()})};
  // A margin for the way from the triangle to the surface along a normal.
  const double margin = 0.03 * std::fmax(box.x1 - box.x0, box.y1 - box.y0);
  box = {box.x0 - margin, box.x1 + margin, box.y0 - margin, box.y1 + margin};
  BaseGap base;
  if (!(affine_ && affine_->over(a, b, c, margin, base)) && !base_gap(box, a, b, c, base)) {
    return kInf;
  }
  // Along the unit direction (-s, 1) / |(s, 1)| the gap closes at (1 + s·grad z) / |(s, 1)|.
  const auto closing = [](const Vec2& s, double off) {
    const double steep = s.norm();
    return (1 + steep * (steep - off)) / std::sqrt(1 + steep * steep);
  };
  double speed = closing(base.slope, base.slope_spread);
  const Vec3 u = b - a, w = c - a;
  const double det = u.x() * w.y() - u.y() * w.x();
  if (det != 0) {
    // s the triangle's own slope: it is the mean slope of the surface along each edge, which slopes
    // elsewhere differ from by what the second derivative does on the way.
    const Vec2 s((u.z() * w.y() - w.z() * u.y()) / det, (u.x() * w.z() - w.x() * u.z()) / det);
    const double lu = u.head<2>().norm(), lw = w.head<2>().norm();
    const double longest = std::fmax(std::fmax(lu, lw), (c - b).head<2>().norm());
    const double off = base.bend * longest * std::sqrt(2.0) * lu * lw / std::fabs(det);
    speed =
        std::fmax(speed, closing(s, std::fmin(off, (s - base.slope).norm() + base.slope_spread)));
  }
  // speed h - bend h² / 2 >= gap
  const double disc = speed * speed - 2 * base.bend * base.gap;
  if (!(speed > 0 && disc > 0)) return base.gap;
  const double h = 2 * base.gap / (speed + std::sqrt(disc));
  return h < base.gap && h < margin ? h : base.gap;
}

}  // namespace diesink
