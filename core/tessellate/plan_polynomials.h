// Polynomials of the plan over a box, and the arithmetic of ranges, of which the bounds of bodies
// and of crossings are made. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/tessellate/cell_bounds.h"

namespace diesink {

constexpr double kUnbounded = std::numeric_limits<double>::infinity();

// A polynomial of degree two about the box's centre.
struct Quadratic {
  double v, gx, gy, hxx, hxy, hyy;
};

inline PlanFunction function_of(const Quadratic& q, const CellBox& box, PlanFunction::Kind kind,
                                std::int32_t solid, std::uint32_t id) {
  PlanFunction f;
  f.kind = kind;
  f.solid = solid;
  f.id = id;
  f.v = q.v;
  f.cgx = q.gx;
  f.cgy = q.gy;
  f.exact = true;
  f.hxx = q.hxx;
  f.hxy = q.hxy;
  f.hyy = q.hyy;
  const double ex = std::fabs(q.hxx) * box.hx + std::fabs(q.hxy) * box.hy;
  const double ey = std::fabs(q.hxy) * box.hx + std::fabs(q.hyy) * box.hy;
  f.gx = {q.gx - ex, q.gx + ex};
  f.gy = {q.gy - ey, q.gy + ey};
  f.bend = 0.5 * (std::fabs(q.hxx) * box.hx * box.hx + std::fabs(q.hyy) * box.hy * box.hy) +
           std::fabs(q.hxy) * box.hx * box.hy;
  const double reach = std::fabs(q.gx) * box.hx + std::fabs(q.gy) * box.hy + f.bend;
  f.lo = q.v - reach;
  f.hi = q.v + reach;
  return f;
}

struct Linear {
  double c, gx, gy;
};

inline Linear cap_at(const PlanarCap& cap, double dx, double dy) {
  return {cap.z0 + cap.zx * dx + cap.zy * dy, cap.zx, cap.zy};
}

inline Range range_of(const Linear& l, const CellBox& box) {
  const double reach = std::fabs(l.gx) * box.hx + std::fabs(l.gy) * box.hy;
  return {l.c - reach, l.c + reach};
}

// q of the side on the plane t(x, y): a conic. Gradient and Hessian by the chain rule.
inline Quadratic side_on(const SideQuadratic& s, double dx, double dy, const Linear& plane) {
  const double t = plane.c - s.cz;
  const double q0 = s.c0 + dx * (s.cx1 + s.cxx * dx + s.cxy * dy) + dy * (s.cy1 + s.cyy * dy);
  const double q1 = s.b0 + s.bx * dx + s.by * dy;
  Quadratic q;
  q.v = (s.q2 * t + 2 * q1) * t + q0;
  const double qt = 2 * (s.q2 * t + q1);
  q.gx = s.cx1 + 2 * s.cxx * dx + s.cxy * dy + 2 * s.bx * t + qt * plane.gx;
  q.gy = s.cy1 + 2 * s.cyy * dy + s.cxy * dx + 2 * s.by * t + qt * plane.gy;
  q.hxx = 2 * (s.cxx + 2 * s.bx * plane.gx + s.q2 * plane.gx * plane.gx);
  q.hyy = 2 * (s.cyy + 2 * s.by * plane.gy + s.q2 * plane.gy * plane.gy);
  q.hxy = s.cxy + 2 * (s.bx * plane.gy + s.by * plane.gx) + 2 * s.q2 * plane.gx * plane.gy;
  return q;
}

inline void set_height(PlanFunction& f, const Linear& plane) {
  f.has_height = true;
  f.hc = plane.c;
  f.hgx = plane.gx;
  f.hgy = plane.gy;
}

inline Range scale(Range r, double f) {
  return f >= 0 ? Range{r.lo * f, r.hi * f} : Range{r.hi * f, r.lo * f};
}
inline Range add(Range a, Range b) { return {a.lo + b.lo, a.hi + b.hi}; }
inline Range times(Range a, Range b) {
  const double p[4] = {a.lo * b.lo, a.lo * b.hi, a.hi * b.lo, a.hi * b.hi};
  // 0 * inf: an unbounded factor makes the product unbounded.
  for (const double v : p) {
    if (std::isnan(v)) return {-kUnbounded, kUnbounded};
  }
  return {std::min({p[0], p[1], p[2], p[3]}), std::max({p[0], p[1], p[2], p[3]})};
}
inline Range divided(Range a, Range b) {
  if (b.lo <= 0 && b.hi >= 0) return {-kUnbounded, kUnbounded};
  return times(a, {1 / b.hi, 1 / b.lo});
}

// Partial derivatives of q over the box for t in a range.
struct SideGradient {
  Range x, y, t;
};

inline SideGradient side_gradient(const SideQuadratic& s, double dx, double dy, const CellBox& box,
                                  Range t) {
  const auto around = [](double c, double r) { return Range{c - r, c + r}; };
  SideGradient g;
  g.x = add(around(s.cx1 + 2 * s.cxx * dx + s.cxy * dy,
                   2 * std::fabs(s.cxx) * box.hx + std::fabs(s.cxy) * box.hy),
            scale(t, 2 * s.bx));
  g.y = add(around(s.cy1 + 2 * s.cyy * dy + s.cxy * dx,
                   2 * std::fabs(s.cyy) * box.hy + std::fabs(s.cxy) * box.hx),
            scale(t, 2 * s.by));
  g.t = add(around(2 * (s.b0 + s.bx * dx + s.by * dy),
                   2 * (std::fabs(s.bx) * box.hx + std::fabs(s.by) * box.hy)),
            scale(t, 2 * s.q2));
  return g;
}

}  // namespace diesink
