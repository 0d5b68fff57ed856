// Where two faces change places over a plan box: enclosures of their crossing.
// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <cmath>
#include <utility>

#include "core/tessellate/cell_bounds.h"
#include "core/tessellate/plan_polynomials.h"

namespace diesink {
namespace {

using Impl = CompoundSurface::Impl;

// q of a side about the box's centre and the height z0: a h² + 2 b(x, y) h + c(x, y).
struct SideAbout {
  double a;
  Linear b;
  Quadratic c;
};

SideAbout side_about(const SideQuadratic& s, const CellBox& box, double z0) {
  const double dx = box.x - s.cx, dy = box.y - s.cy, d = z0 - s.cz;
  return {
      s.q2, {s.b0 + s.bx * dx + s.by * dy + s.q2 * d, s.bx, s.by}, side_on(s, dx, dy, {z0, 0, 0})};
}

// Where two sides meet, the member q_f - lambda q_g of their pencil without h² vanishes, too:
// c(x, y) + 2 b(x, y) h = 0. Where b is nothing (middle planes that coincide: axes and centres at
// one height), c alone is the curve's plan; where it is a plane (spheres, parallel cylinders of one
// form), the curve is the conic in which that plane cuts f. Neither minds a silhouette.
// False where the member is of neither kind.
bool pencil_over(const Impl& surface, const FaceOver& f, const FaceOver& g, const CellBox& box,
                 PlanFunction& p) {
  const SideQuadratic& sf = surface.bodies[static_cast<std::size_t>(f.solid)].side();
  const SideQuadratic& sg = surface.bodies[static_cast<std::size_t>(g.solid)].side();
  if (!(sf.q2 > 0) || !(sg.q2 > 0)) return false;
  const double z0 = f.c;
  const SideAbout mf = side_about(sf, box, z0), mg = side_about(sg, box, z0);
  const double lambda = mf.a / mg.a;
  // What rounding may leave of a term that cancels, relative to its parts.
  constexpr double kNothing = 1e-13;
  bool rounded = true;  // of what has been parted since it was last set
  const auto part = [&](double a, double b) {
    const double d = a - lambda * b;
    const bool nothing = std::fabs(d) <= kNothing * (std::fabs(a) + lambda * std::fabs(b));
    rounded = rounded && nothing;
    return nothing ? 0.0 : d;
  };
  // Offsets of the coefficients from cancelling: measured against the part's size, for the centre
  // of a box may be near a zero of each.
  const double size = surface.size;
  const auto part_to = [&](double a, double b, double scale) {
    const double d = a - lambda * b;
    return std::fabs(d) <= kNothing * scale ? 0.0 : d;
  };
  const double b_scale = mf.a * size;
  const Linear b{part_to(mf.b.c, mg.b.c, b_scale), part(mf.b.gx, mg.b.gx), part(mf.b.gy, mg.b.gy)};
  Quadratic c;
  c.v = mf.c.v - lambda * mg.c.v;
  c.gx = mf.c.gx - lambda * mg.c.gx;
  c.gy = mf.c.gy - lambda * mg.c.gy;
  rounded = true;
  c.hxx = part(mf.c.hxx, mg.c.hxx);
  c.hxy = part(mf.c.hxy, mg.c.hxy);
  c.hyy = part(mf.c.hyy, mg.c.hyy);
  PlanFunction q;
  if (b.c == 0 && b.gx == 0 && b.gy == 0) {
    q = function_of(c, box, PlanFunction::Kind::kCrossing, f.solid, 0);
  } else if (b.gx == 0 && b.gy == 0 && rounded) {
    const double k = -0.5 / b.c;
    const Linear plane{z0 + k * c.v, k * c.gx, k * c.gy};
    if (!(std::fabs(plane.gx) + std::fabs(plane.gy) < 1e4)) return false;  // too steep to be exact
    q = function_of(side_on(sf, box.x - sf.cx, box.y - sf.cy, plane), box,
                    PlanFunction::Kind::kCrossing, f.solid, 0);
  } else {
    return false;
  }
  p.take_values(q);
  return true;
}

// Two round cylinders of one radius whose axes meet, as the rounded edges of a block do in its
// corner: they cross in the planes that halve the angles between their axes, and the curve's plan
// is the conic in which such a plane cuts the one, or a straight line where it is upright. Neither
// minds a silhouette. False where the two are others, where in the box they may cross in both
// planes, or in none.
bool mitre_over(const Impl& surface, const FaceOver& f, const FaceOver& g, const CellBox& box,
                PlanFunction& p) {
  const BodyLine& line = surface.bodies[static_cast<std::size_t>(f.solid)];
  const auto* one = std::get_if<QuadricBody>(&line.body());
  const auto* two =
      std::get_if<QuadricBody>(&surface.bodies[static_cast<std::size_t>(g.solid)].body());
  const auto is_round = [](const QuadricBody* body) {
    return body != nullptr && body->shape == QuadricShape::kCylinder && body->A == body->B;
  };
  if (!is_round(one) || !is_round(two) || one->A != two->A) return false;
  const Vec3 a = one->frame.row(2), b = two->frame.row(2), normal = a.cross(b);
  // What rounding may leave between axes that meet, of the size; a sine under which they are one.
  constexpr double kNothing = 1e-14, kParallel = 1e-3;
  const double sine = normal.norm();
  const Vec3 apart = two->p - one->p;
  if (!(sine > kParallel) || std::fabs(apart.dot(normal)) > kNothing * sine * surface.size)
    return false;
  const Vec3 centre = one->p + apart.cross(b).dot(normal) / (sine * sine) * a;
  // n·(r - centre) on a face over the box.
  const auto may_vanish = [&](const Vec3& n, const FaceOver& face) {
    const double v = n.dot(Vec3(box.x, box.y, face.c) - centre);
    const double reach =
        std::fabs(n.x() + n.z() * face.gx) * box.hx + std::fabs(n.y() + n.z() * face.gy) * box.hy;
    const Range rest = scale({face.lo, face.hi}, n.z());
    return v + reach + rest.hi >= 0 && v - reach + rest.lo <= 0;
  };
  const auto may_cross = [&](const Vec3& n) { return may_vanish(n, f) && may_vanish(n, g); };
  const Vec3 inner = a - b, outer = a + b;
  if (may_cross(inner) == may_cross(outer)) return false;
  const Vec3& n = may_cross(inner) ? inner : outer;
  const double v = n.dot(Vec3(box.x, box.y, centre.z()) - centre);
  constexpr double kUpright = 1e-4;
  if (std::fabs(n.z()) <= kUpright * n.norm()) {
    // An upright plane is a line of the plan; of one that is all but upright heights say nothing.
    if (n.z() != 0) return false;
    p.take_values(
        function_of({v, n.x(), n.y(), 0, 0, 0}, box, PlanFunction::Kind::kCrossing, f.solid, 0));
    return true;
  }
  const SideQuadratic& s = line.side();
  const Linear plane{centre.z() - v / n.z(), -n.x() / n.z(), -n.y() / n.z()};
  p.take_values(function_of(side_on(s, box.x - s.cx, box.y - s.cy, plane), box,
                            PlanFunction::Kind::kCrossing, f.solid, 0));
  return true;
}

// Where a side all but touches a plane the conic in which they meet is two lines a hair apart, or
// none: seen from its roots along one axis, which are two, or none, all over the box.
// `least`: what the form has to be beyond zero between the two, lest ties make them one.
// Source: the discriminant of a conic by rows is a polynomial of degree two; it lies between its
//         Bernstein coefficients.
void part_branches(const CellBox& box, double least, PlanFunction& p) {
  if (!p.exact) return;
  struct Rows {  // the form is a u² + 2 (b0 + b1 v) u + c0 + c1 v + c2 v², u along the rows
    double a, b0, b1, c0, c1, c2, h;
    TwoGraphs graphs;
  };
  Rows ways[2] = {
      {0.5 * p.hxx, 0.5 * p.cgx, 0.5 * p.hxy, p.v, p.cgy, 0.5 * p.hyy, box.hy, TwoGraphs::kOverY},
      {0.5 * p.hyy, 0.5 * p.cgy, 0.5 * p.hxy, p.v, p.cgx, 0.5 * p.hxx, box.hx, TwoGraphs::kOverX}};
  // Across the lines first.
  if (std::fabs(ways[0].a) < std::fabs(ways[1].a)) std::swap(ways[0], ways[1]);
  for (const Rows& r : ways) {
    if (r.a == 0) continue;
    const double d0 = r.b0 * r.b0 - r.a * r.c0, d1 = 2 * r.b0 * r.b1 - r.a * r.c1,
                 d2 = r.b1 * r.b1 - r.a * r.c2;
    const double first = d0 + (d2 * r.h - d1) * r.h, last = d0 + (d2 * r.h + d1) * r.h,
                 middle = d0 - d2 * r.h * r.h;
    const double guard = std::fabs(r.a) * least;
    if (std::fmax(std::fmax(first, middle), last) < -guard) {
      (r.a > 0 ? p.lo : p.hi) = r.a;  // no root in any row
      return;
    }
    if (!(std::fmin(std::fmin(first, middle), last) > guard)) continue;
    // A branch of a conic turns one way: most between its ends.
    const double at_first = 0.5 * (d1 - 2 * d2 * r.h) / std::sqrt(first),
                 at_last = 0.5 * (d1 + 2 * d2 * r.h) / std::sqrt(last);
    constexpr double kStraight = 0.6;  // radians, as of a regular function's gradient
    bool straight = true;
    for (const double sign : {-1.0, 1.0}) {
      straight = straight && std::fabs(std::atan((-r.b1 + sign * at_first) / r.a) -
                                       std::atan((-r.b1 + sign * at_last) / r.a)) < kStraight;
    }
    if (!straight) continue;
    p.two = r.graphs;
    return;
  }
}

// What a plane that is all but upright does to a side's form is lost in its slope: there the
// difference of heights is the better function, as straight as the plane's edge.
bool is_far_steeper(const FaceOver& plane, const FaceOver& side) {
  constexpr double kSteep = 1e3;
  const double steep = std::fabs(plane.gx) + std::fabs(plane.gy);
  return side.tangent && steep > kSteep &&
         steep > kSteep * std::fmax(std::fmax(std::fabs(side.zx.lo), std::fabs(side.zx.hi)),
                                    std::fmax(std::fabs(side.zy.lo), std::fabs(side.zy.hi)));
}

}  // namespace

bool sides_run_apart(const Impl& surface, const FaceOver& f, const FaceOver& g,
                     const CellBox& box) {
  if (!f.side || !g.side || !f.has_mid || !g.has_mid || !f.tangent || !g.tangent) return false;
  PlanFunction q;
  return pencil_over(surface, f, g, box, q) && (q.lo > 0 || q.hi < 0);
}

Range side_form_over(const Impl& surface, const FaceOver& side, const FaceOver& height,
                     const CellBox& box) {
  const SideQuadratic& s = surface.bodies[static_cast<std::size_t>(side.solid)].side();
  const double dx = box.x - s.cx, dy = box.y - s.cy;
  const PlanFunction q = function_of(side_on(s, dx, dy, {height.c, height.gx, height.gy}), box,
                                     PlanFunction::Kind::kCrossing, side.solid, 0);
  const double reach = std::fabs(height.gx) * box.hx + std::fabs(height.gy) * box.hy;
  const double t = height.c - s.cz;
  const Range by_height =
      side_gradient(s, dx, dy, box, {t - reach + height.lo, t + reach + height.hi}).t;
  return add({q.lo, q.hi}, times(by_height, {height.lo, height.hi}));
}

PlanFunction crossing_over(const Impl& surface, const FaceOver& f, const FaceOver& g,
                           const CellBox& box) {
  PlanFunction p;
  p.kind = PlanFunction::Kind::kCrossing;
  p.solid = f.solid;
  p.a = f.label;
  p.b = g.label;
  p.id = 0;
  // The steeper side is taken as the implicit one, the other as a height in it.
  const FaceOver* implicit = nullptr;
  const FaceOver* height = nullptr;
  if (f.side && (!g.side || !f.tangent)) {
    implicit = &f;
    height = &g;
  } else if (g.side) {
    implicit = &g;
    height = &f;
  }
  const auto is_planar = [](const FaceOver& face) {
    return !face.side && (face.solid >= 0 || (face.lo == 0 && face.hi == 0));
  };
  const bool planar = height != nullptr && is_planar(*height);
  if (implicit != nullptr && !(planar && is_far_steeper(*height, *implicit))) {
    p.implicit_side = true;
    p.implicit_label = implicit->label;
    const SideQuadratic& s = surface.bodies[static_cast<std::size_t>(implicit->solid)].side();
    const double dx = box.x - s.cx, dy = box.y - s.cy;
    if (planar) {
      const PlanFunction q = function_of(side_on(s, dx, dy, {height->c, height->gx, height->gy}),
                                         box, PlanFunction::Kind::kCrossing, f.solid, 0);
      p.take_values(q);
      // (Two lines along an axis are regular across it by what they lean, which says little.)
      if (!(p.lo > 0 || p.hi < 0) && !(p.regular() && p.is_nearly_straight())) {
        const double reach = std::fabs(height->gx) * box.hx + std::fabs(height->gy) * box.hy;
        const double t = height->c - s.cz;
        const Range rise = side_gradient(s, dx, dy, box, {t - reach, t + reach}).t;
        part_branches(
            box, kLineSlack * surface.tie * std::fmax(std::fabs(rise.lo), std::fabs(rise.hi)), p);
      }
      return p;
    }
    const double reach = std::fabs(height->gx) * box.hx + std::fabs(height->gy) * box.hy;
    const double t = height->c - s.cz;
    const SideGradient r =
        side_gradient(s, dx, dy, box, {t - reach + height->lo, t + reach + height->hi});
    p.gx = add(r.x, times(r.t, height->zx));
    p.gy = add(r.y, times(r.t, height->zy));
    p.lo = -kUnbounded;
    p.hi = kUnbounded;
    p.bend = kUnbounded;
    if (f.side && g.side && f.has_mid && g.has_mid) {
      PlanFunction q = p;
      if (pencil_over(surface, f, g, box, q) || mitre_over(surface, f, g, box, q)) {
        q.implicit_side = false;
        // Elsewhere than over the whole box a side that does not meet the other may still be the
        // higher of the two here and be gone there.
        if (!f.tangent || !g.tangent) q.lo = -kUnbounded, q.hi = kUnbounded;
        if (!p.regular()) return q;
        p.lo = q.lo;
        p.hi = q.hi;
      }
    }
    return p;
  }
  p.gx = {f.zx.lo - g.zx.hi, f.zx.hi - g.zx.lo};
  p.gy = {f.zy.lo - g.zy.hi, f.zy.hi - g.zy.lo};
  const Range d = difference_over(f, g, box);
  p.v = f.c - g.c;
  p.cgx = f.gx - g.gx;
  p.cgy = f.gy - g.gy;
  p.lo = d.lo;
  p.hi = d.hi;
  p.bend = f.hi - f.lo + g.hi - g.lo;
  p.exact = p.bend == 0;
  return p;
}

}  // namespace diesink