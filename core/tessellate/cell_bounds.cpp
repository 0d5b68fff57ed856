// Enclosures over plan boxes. A body is convex, so its upper height is concave over its convex
// shadow: a tangent plane bounds it from above, the corners from below; the discriminant and the
// rims are conics whose gradients are linear. Source: Choi et al. 1988, equations (7) to (10);
// convexity as in docs/tessellation.md.
// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/cell_bounds.h"

#include <algorithm>
#include <cmath>

#include "core/tessellate/plan_polynomials.h"

namespace diesink {
namespace {

using Impl = CompoundSurface::Impl;

// The side's root over the box as tangent plane plus remainder, or middle plane plus remainder.
bool side_over(const Impl& surface, const BodyLine& body, bool upper, const CellBox& box,
               const PlanFunction* disc, bool corners_defined, FaceOver& f) {
  const SideQuadratic& s = body.side();
  const double dx = box.x - s.cx, dy = box.y - s.cy;
  const double guard = std::ldexp(surface.size, -48);  // rounding of a root, a few ulp of the size
  f.side = true;
  const bool between = body.side_rule() == SideRule::kBetween && s.q2 > 0;
  if (between) {
    f.has_mid = true;
    f.mc = s.cz - (s.b0 + s.bx * dx + s.by * dy) / s.q2;
    f.mgx = -s.bx / s.q2;
    f.mgy = -s.by / s.q2;
  }
  if (corners_defined) {
    double z = 0;
    if (body.face_height(kFaceSide, upper, box.x, box.y, z)) {
      const double t = z - s.cz;
      const double q1 = s.b0 + s.bx * dx + s.by * dy;
      const double ft = 2 * (s.q2 * t + q1);
      const double fx = s.cx1 + 2 * s.cxx * dx + s.cxy * dy + 2 * s.bx * t;
      const double fy = s.cy1 + 2 * s.cyy * dy + s.cxy * dx + 2 * s.by * t;
      double gx = -fx / ft, gy = -fy / ft;
      if (!std::isfinite(gx) || !std::isfinite(gy)) {
        // The apex of a cone: the plane across its axis supports it.
        const Vec3 a = std::get<QuadricBody>(body.body()).frame.row(2);
        gx = -a.x() / a.z();
        gy = -a.y() / a.z();
      }
      if (std::isfinite(gx) && std::isfinite(gy)) {
        double lo = 0, hi = 0;
        bool all = true;
        for (int k = 0; k < 4 && all; ++k) {
          const double ox = k & 1 ? box.hx : -box.hx, oy = k & 2 ? box.hy : -box.hy;
          double zc = 0;
          all = body.face_height(kFaceSide, upper, box.x + ox, box.y + oy, zc);
          const double gap = zc - (z + gx * ox + gy * oy);
          lo = std::fmin(lo, gap);
          hi = std::fmax(hi, gap);
        }
        if (all) {
          f.tangent = true;
          f.c = z;
          f.gx = gx;
          f.gy = gy;
          f.lo = (upper ? lo : 0) - guard;
          f.hi = (upper ? 0 : hi) + guard;
          const double reach = std::fabs(gx) * box.hx + std::fabs(gy) * box.hy;
          const SideGradient g =
              side_gradient(s, dx, dy, box, {t - reach + f.lo, t + reach + f.hi});
          // Only derivatives of the wanted sheet matter: q_t keeps the sheet's sign up to the
          // silhouette.
          f.zx = scale(divided(g.x, g.t), -1);
          f.zy = scale(divided(g.y, g.t), -1);
          return true;
        }
      }
    }
  }
  if (!between || disc == nullptr) {
    // Upright paraboloids and steep cones have their root everywhere; a corner failed only by
    // rounding.
    f.c = 0.5 * (body.z_low() + body.z_high());
    f.lo = body.z_low() - f.c - guard;
    f.hi = body.z_high() - f.c + guard;
    return true;
  }
  const double height = std::sqrt(std::fmax(disc->hi, 0)) / s.q2;
  f.c = f.mc;
  f.gx = f.mgx;
  f.gy = f.mgy;
  f.lo = (upper ? 0 : -height) - guard;
  f.hi = (upper ? height : 0) + guard;
  return true;
}

// The rim of a cap that is all but upright is two lines a hair apart in plan, of which one borders
// the shadow: where the cap meets the far sheet of the side, a lower cap the upper one. That is one
// regular function, the difference of their heights, positive inside, which takes the place of the
// rim's conic. False where it is none, or the conic is good enough.
bool take_border_of_steep_cap(const Impl& surface, const BodyLine& body, bool cap_is_upper,
                              const Linear& cap, const CellBox& box, const PlanFunction& disc,
                              PlanFunction& rim) {
  // Slopes from which on the two lines lie closer than a three-hundredth of the rim's radius: cells
  // that small along a rim are still few.
  constexpr double kSteep = 300;
  if (!(std::fabs(cap.gx) + std::fabs(cap.gy) > kSteep) ||
      (rim.regular() && rim.is_nearly_straight()) || !(disc.lo > 0) ||
      std::get<QuadricBody>(body.body()).shape != QuadricShape::kCylinder)
    return false;
  FaceOver sheet;
  side_over(surface, body, !cap_is_upper, box, &disc, true, sheet);
  if (!sheet.tangent) return false;
  const double sign = cap_is_upper ? 1 : -1;
  PlanFunction f = rim;
  f.v = sign * (cap.c - sheet.c);
  f.cgx = sign * (cap.gx - sheet.gx);
  f.cgy = sign * (cap.gy - sheet.gy);
  f.gx = scale({cap.gx - sheet.zx.hi, cap.gx - sheet.zx.lo}, sign);
  f.gy = scale({cap.gy - sheet.zy.hi, cap.gy - sheet.zy.lo}, sign);
  f.bend = sheet.hi - sheet.lo;
  f.exact = false;
  f.hxx = f.hxy = f.hyy = 0;
  const Range rest = scale({-sheet.hi, -sheet.lo}, sign);
  const double reach = std::fabs(f.cgx) * box.hx + std::fabs(f.cgy) * box.hy;
  f.lo = f.v - reach + rest.lo;
  f.hi = f.v + reach + rest.hi;
  if (!f.regular()) return false;
  rim = f;
  return true;
}

}  // namespace

bool PlanFunction::is_nearly_straight() const {
  if (two != TwoGraphs::kNo) return true;
  constexpr double kTangent = 0.6;  // of 31 degrees
  const double mx = 0.5 * (gx.lo + gx.hi), my = 0.5 * (gy.lo + gy.hi);
  for (const double x : {gx.lo, gx.hi}) {
    for (const double y : {gy.lo, gy.hi}) {
      // (False for NaN.)
      if (!(std::fabs(mx * y - my * x) < kTangent * (mx * x + my * y))) return false;
    }
  }
  return true;
}

Range difference_over(const FaceOver& f, const FaceOver& g, const CellBox& box) {
  if (f.same >= 0 && f.same == g.same) return {0, 0};
  const double reach = std::fabs(f.gx - g.gx) * box.hx + std::fabs(f.gy - g.gy) * box.hy;
  const double c = f.c - g.c;
  return {c - reach + f.lo - g.hi, c + reach + f.hi - g.lo};
}

void body_over(const Impl& surface, const CompoundStep& step, bool upper, const CellBox& box,
               BodyOver& out) {
  const BodyLine& body = surface.bodies[static_cast<std::size_t>(step.solid)];
  out.faces.clear();
  out.shadow.clear();
  out.rims.clear();
  out.coverage = Coverage::kOutside;
  const PlanBox& plan = body.plan_box();
  if (box.x + box.hx < plan.x0 || box.x - box.hx > plan.x1 || box.y + box.hy < plan.y0 ||
      box.y - box.hy > plan.y1) {
    return;
  }
  const SideQuadratic& s = body.side();
  const double dx = box.x - body.center_x(), dy = box.y - body.center_y();
  const double slack = body.slack();

  // The shadow: every function below is positive inside.
  std::uint32_t id = 0;
  for (const PlanHalf& h : body.halves()) {
    const PlanFunction f = function_of({-(h.a * dx + h.b * dy + h.c), -h.a, -h.b, 0, 0, 0}, box,
                                       PlanFunction::Kind::kShadow, step.solid, id++);
    if (f.hi < -slack) return;
    // The line along an upright ruling's apex is no border but touches the rim, which is one.
    const bool by_apex = h.face == kFaceSide && body.side_rule() != SideRule::kBetween;
    if (f.lo <= slack && !by_apex) out.shadow.push(f);
  }
  PlanFunction disc;
  bool has_disc = false;
  const bool between = body.has_side() && body.side_rule() == SideRule::kBetween && s.q2 > 0;
  Linear mid{0, 0, 0};
  if (body.has_side() && body.side_rule() == SideRule::kColumn) {
    Quadratic q = side_on(s, dx, dy, {s.cz, 0, 0});
    q = {-q.v, -q.gx, -q.gy, -q.hxx, -q.hxy, -q.hyy};
    const PlanFunction f = function_of(q, box, PlanFunction::Kind::kShadow, step.solid, 100);
    if (f.hi < -s.disc_slack) return;
    if (f.lo <= s.disc_slack) out.shadow.push(f);
  } else if (between) {
    const Quadratic q{s.d0 + dx * (s.dx1 + s.dxx * dx + s.dxy * dy) + dy * (s.dy1 + s.dyy * dy),
                      s.dx1 + 2 * s.dxx * dx + s.dxy * dy,
                      s.dy1 + 2 * s.dyy * dy + s.dxy * dx,
                      2 * s.dxx,
                      s.dxy,
                      2 * s.dyy};
    disc = function_of(q, box, PlanFunction::Kind::kSilhouette, step.solid, 101);
    has_disc = true;
    if (disc.hi < -s.disc_slack) return;
    mid = {s.cz - (s.b0 + s.bx * dx + s.by * dy) / s.q2, -s.bx / s.q2, -s.by / s.q2};
    set_height(disc, mid);
    bool on_body = disc.lo <= s.disc_slack;
    // Where the silhouette's height is beyond a cap for sure, the rim is the border, not the
    // silhouette.
    for (const PlanarCap& cap : body.upper_caps()) {
      const Linear l = cap_at(cap, dx, dy);
      const Range r = range_of({mid.c - l.c, mid.gx - l.gx, mid.gy - l.gy}, box);
      if (r.lo > slack) on_body = false;
    }
    for (const PlanarCap& cap : body.lower_caps()) {
      const Linear l = cap_at(cap, dx, dy);
      const Range r = range_of({mid.c - l.c, mid.gx - l.gx, mid.gy - l.gy}, box);
      if (r.hi < -slack) on_body = false;
    }
    if (on_body && body.silhouette_lines().empty()) out.shadow.push(disc);
    std::uint32_t line = 101;
    for (const PlanHalf& h : body.silhouette_lines()) {
      PlanFunction f = function_of({-(h.a * dx + h.b * dy + h.c), -h.a, -h.b, 0, 0, 0}, box,
                                   PlanFunction::Kind::kSilhouette, step.solid, line++);
      const double close = slack * (std::fabs(h.a) + std::fabs(h.b));
      if (f.hi < -close) return;
      if (!on_body || f.lo > close) continue;
      set_height(f, mid);
      out.shadow.push(f);
    }
  }
  // Two planar faces that meet at the border.
  id = 200;
  for (const PlanarCap& u : body.upper_caps()) {
    for (const PlanarCap& l : body.lower_caps()) {
      const Linear a = cap_at(u, dx, dy), b = cap_at(l, dx, dy);
      PlanFunction f = function_of({a.c - b.c, a.gx - b.gx, a.gy - b.gy, 0, 0, 0}, box,
                                   PlanFunction::Kind::kShadow, step.solid, id++);
      set_height(f, a);
      if (f.hi < -slack) return;
      if (f.lo <= slack) out.shadow.push(f);
    }
  }
  // A cap and the side: the rim's conic. It borders the shadow where the cap is beyond the
  // silhouette.
  struct RimOver {
    PlanFunction f;
    bool side_hidden = false, cap_hidden = false;
  };
  ShortList<RimOver, 4> rims;
  const bool has_root_side = body.has_side() && body.side_rule() != SideRule::kColumn;
  const auto rim = [&](const PlanarCap& cap, bool cap_is_upper) {
    const Linear l = cap_at(cap, dx, dy);
    Quadratic q = side_on(s, dx, dy, l);
    q = {-q.v, -q.gx, -q.gy, -q.hxx, -q.hxy, -q.hyy};  // positive where the cap is inside the side
    RimOver r;
    r.f = function_of(q, box, PlanFunction::Kind::kRim, step.solid, 300u + cap.face);
    set_height(r.f, l);
    // Height of the cap above the silhouette, towards the cap's own side.
    Range above{-kUnbounded, kUnbounded};
    if (between) {
      above = range_of({l.c - mid.c, l.gx - mid.gx, l.gy - mid.gy}, box);
      if (!cap_is_upper) above = scale(above, -1);
    }
    const bool one_root =
        !between;  // the only root lies on the other side of the body than the cap
    // What the form may be where meet() still finds the body: root and cap within the slack of each
    // other, up or sideways, or a discriminant that counts as touching, over q2 as the form is.
    const auto most = [](const Range& g) { return std::fmax(std::fabs(g.lo), std::fabs(g.hi)); };
    const Range q1 = range_of({s.b0 + s.bx * dx + s.by * dy + s.q2 * (l.c - s.cz),
                               s.bx + s.q2 * l.gx, s.by + s.q2 * l.gy},
                              box);
    const double tiny =
        (between ? s.disc_slack / s.q2 : 0) + slack * (most(r.f.gx) + most(r.f.gy) + 2 * most(q1));
    bool outside = false, borders = false;
    if (one_root) {
      outside = r.f.hi < -tiny;
      borders = r.f.lo <= tiny;
    } else {
      outside = r.f.hi < -tiny && above.hi < -slack;
      borders = r.f.lo <= tiny && r.f.hi >= -tiny && above.lo <= slack;
    }
    if (borders && !outside) {
      PlanFunction f = r.f;
      // What the slack in plan makes of heights on a steep cap.
      const auto may_vanish = [&] {
        const double off = slack * (1 + most(f.gx) + most(f.gy));
        return f.lo <= off && f.hi >= -off;
      };
      if (!between || !take_border_of_steep_cap(surface, body, cap_is_upper, l, box, disc, f) ||
          may_vanish())
        out.shadow.push(f);
    }
    if (cap_is_upper == upper && between) {
      r.side_hidden = r.f.lo > 0;  // the cap cuts the body before the side's root
      r.cap_hidden = r.f.hi < 0 && above.lo > slack;  // the cap is beyond the root
    } else {
      // the cap is on the other side of the body
      r.side_hidden = r.cap_hidden = false;
    }
    rims.push(r);
    return outside;
  };
  if (has_root_side) {
    for (const PlanarCap& cap : body.upper_caps()) {
      if (rim(cap, true)) return;
    }
    for (const PlanarCap& cap : body.lower_caps()) {
      if (rim(cap, false)) return;
    }
  }

  // Coverage: the shadow is convex, so four corners inside are the box inside.
  LineHit hit;
  bool inside = true;
  for (int k = 0; k < 4 && inside; ++k) {
    inside = body.meet(box.x + (k & 1 ? box.hx : -box.hx), box.y + (k & 2 ? box.hy : -box.hy), hit);
  }
  out.coverage = inside ? Coverage::kInside : Coverage::kPartly;
  if (inside) out.shadow.clear();

  // Faces on the wanted side.
  const auto base_face = [&](std::uint8_t number) {
    FaceOver f;
    f.label = make_label(step.first_row, number);
    f.solid = step.solid;
    f.face = number;
    f.upper = upper;
    return f;
  };
  bool side_possible = has_root_side;
  if (body.side_rule() == SideRule::kBelowFirst && !upper) side_possible = false;
  if (body.side_rule() == SideRule::kAboveLast && upper) side_possible = false;
  if (has_root_side && body.side_rule() == SideRule::kBetween && s.q2 == 0) {
    side_possible = (s.b0 < 0) != upper;  // upright paraboloid: one root
  }
  for (const RimOver& r : rims) side_possible = side_possible && !r.side_hidden;
  if (side_possible) {
    FaceOver f = base_face(kFaceSide);
    f.same = 2 * surface.side_class[static_cast<std::size_t>(step.solid)] + (upper ? 1 : 0);
    bool defined = inside || !between;
    if (!defined && disc.lo > 0) {
      // The whole box is inside the strip or wedge of the side; a cone's wedge must be its own.
      defined = true;
      if (std::get<QuadricBody>(body.body()).shape == QuadricShape::kCone) {
        const Vec3 a = std::get<QuadricBody>(body.body()).frame.row(2);
        for (int k = 0; k < 4; ++k) {
          const double ox = dx + (k & 1 ? box.hx : -box.hx), oy = dy + (k & 2 ? box.hy : -box.hy);
          const double t = -(s.b0 + s.bx * ox + s.by * oy) / s.q2;
          if (a.x() * ox + a.y() * oy + a.z() * t >= 0) defined = false;  // beyond the apex
        }
      }
    }
    side_over(surface, body, upper, box, has_disc ? &disc : nullptr, defined, f);
    out.faces.push(f);
  }
  for (const PlanarCap& cap : upper ? body.upper_caps() : body.lower_caps()) {
    bool hidden = false;
    for (const RimOver& r : rims) hidden = hidden || (r.cap_hidden && r.f.id == 300u + cap.face);
    if (hidden) continue;
    const Linear l = cap_at(cap, dx, dy);
    FaceOver f = base_face(cap.face);
    f.c = l.c;
    f.gx = l.gx;
    f.gy = l.gy;
    f.zx = {l.gx, l.gx};
    f.zy = {l.gy, l.gy};
    out.faces.push(f);
  }
  // Drop faces that another of the body cuts off for sure.
  const auto cut_off = [&](const FaceOver& f) {
    for (const FaceOver& g : out.faces) {
      if (&g == &f) continue;
      const Range d = difference_over(g, f, box);
      if (upper ? d.hi < 0 : d.lo > 0) return true;
    }
    return false;
  };
  bool keep[12];
  for (int i = 0; i < out.faces.count; ++i) keep[i] = !cut_off(out.faces[i]);
  int kept = 0;
  for (int i = 0; i < out.faces.count; ++i) {
    if (keep[i]) out.faces[kept++] = out.faces[i];
  }
  out.faces.count = kept;

  // Where the remaining faces may meet.
  for (int i = 0; i < out.faces.count; ++i) {
    for (int j = i + 1; j < out.faces.count; ++j) {
      const FaceOver &f = out.faces[i], &g = out.faces[j];
      PlanFunction p;
      if (f.side || g.side) {
        const std::uint8_t cap = f.side ? g.face : f.face;
        for (const RimOver& r : rims) {
          if (r.f.id == 300u + cap) p = r.f;
        }
      } else {
        p = function_of({f.c - g.c, f.gx - g.gx, f.gy - g.gy, 0, 0, 0}, box,
                        PlanFunction::Kind::kFaces, step.solid, 1000u + 16u * f.face + g.face);
      }
      p.a = f.label;
      p.b = g.label;
      if (p.lo <= slack && p.hi >= -slack) out.rims.push(p);
    }
  }
}

}  // namespace diesink
