// Enclosures over plan boxes. A body is convex, so its upper height is concave over its convex
// shadow: a tangent plane bounds it from above, the corners from below; the discriminant and the
// rims are conics whose gradients are linear. Source: Choi et al. 1988, equations (7) to (10);
// convexity as in docs/tessellation.md. SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/cell_bounds.h"

#include <algorithm>
#include <cmath>

namespace diesink {
namespace {

using Impl = CompoundSurface::Impl;
constexpr double kInf = std::numeric_limits<double>::infinity();

// A polynomial of degree two about the box's centre.
struct Quadratic {
  double v, gx, gy, hxx, hxy, hyy;
};

PlanFunction function_of(const Quadratic& q, const CellBox& box, PlanFunction::Kind kind,
                         std::int32_t solid, std::uint32_t id) {
  PlanFunction f;
  f.kind = kind;
  f.solid = solid;
  f.id = id;
  f.v = q.v;
  f.cgx = q.gx;
  f.cgy = q.gy;
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

Linear cap_at(const PlanarCap& cap, double dx, double dy) {
  return {cap.z0 + cap.zx * dx + cap.zy * dy, cap.zx, cap.zy};
}

Range range_of(const Linear& l, const CellBox& box) {
  const double reach = std::fabs(l.gx) * box.hx + std::fabs(l.gy) * box.hy;
  return {l.c - reach, l.c + reach};
}

// q of the side on the plane t(x, y): a conic. Gradient and Hessian by the chain rule.
Quadratic side_on(const SideQuadratic& s, double dx, double dy, const Linear& plane) {
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

void set_height(PlanFunction& f, const Linear& plane) {
  f.has_height = true;
  f.hc = plane.c;
  f.hgx = plane.gx;
  f.hgy = plane.gy;
}

Range scale(Range r, double f) {
  return f >= 0 ? Range{r.lo * f, r.hi * f} : Range{r.hi * f, r.lo * f};
}
Range add(Range a, Range b) { return {a.lo + b.lo, a.hi + b.hi}; }
Range times(Range a, Range b) {
  const double p[4] = {a.lo * b.lo, a.lo * b.hi, a.hi * b.lo, a.hi * b.hi};
  // 0 * inf: an unbounded factor makes the product unbounded.
  for (const double v : p) {
    if (std::isnan(v)) return {-kInf, kInf};
  }
  return {std::min({p[0], p[1], p[2], p[3]}), std::max({p[0], p[1], p[2], p[3]})};
}
Range divided(Range a, Range b) {
  if (b.lo <= 0 && b.hi >= 0) return {-kInf, kInf};
  return times(a, {1 / b.hi, 1 / b.lo});
}

// Partial derivatives of q over the box for t in a range.
struct SideGradient {
  Range x, y, t;
};

SideGradient side_gradient(const SideQuadratic& s, double dx, double dy, const CellBox& box,
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

// The border of a scan in the box: one function for edges that follow one another, whose direction
// is somewhere among theirs.
void scan_outline(const ScannedSurface& scan, const CellBox& box, FunctionList& outline) {
  constexpr std::size_t kMost = 24;
  std::vector<std::uint32_t> edges;
  scan.border_over({box.x - box.hx, box.x + box.hx, box.y - box.hy, box.y + box.hy}, kMost, edges);
  const std::vector<ScannedSurface::BorderEdge>& border = scan.border_edges();
  std::vector<PlanFunction> runs;
  std::vector<std::vector<std::uint32_t>> ends;  // vertices of each run's edges
  for (const std::uint32_t e : edges) {
    const Vec3 &a = scan.positions()[border[e][0]], &b = scan.positions()[border[e][1]];
    const double length = std::hypot(b.x() - a.x(), b.y() - a.y());
    PlanFunction f;
    f.kind = PlanFunction::Kind::kOutline;
    f.id = e;
    f.cgx = length > 0 ? -(b.y() - a.y()) / length : 0;
    f.cgy = length > 0 ? (b.x() - a.x()) / length : 0;
    const double turned = 0x1p-50;
    f.gx = {f.cgx - turned, f.cgx + turned};
    f.gy = {f.cgy - turned, f.cgy + turned};
    f.v = f.cgx * (box.x - a.x()) + f.cgy * (box.y - a.y());
    f.lo = -kInf;
    f.hi = kInf;
    std::vector<std::uint32_t> own{border[e][0], border[e][1]};
    // Joined with every run it touches.
    for (std::size_t k = 0; k < runs.size();) {
      bool touches = false;
      for (const std::uint32_t v : own) {
        touches = touches || std::find(ends[k].begin(), ends[k].end(), v) != ends[k].end();
      }
      if (!touches) {
        ++k;
        continue;
      }
      f.gx = {std::fmin(runs[k].gx.lo, f.gx.lo), std::fmax(runs[k].gx.hi, f.gx.hi)};
      f.gy = {std::fmin(runs[k].gy.lo, f.gy.lo), std::fmax(runs[k].gy.hi, f.gy.hi)};
      f.bend = kInf;
      own.insert(own.end(), ends[k].begin(), ends[k].end());
      runs.erase(runs.begin() + static_cast<std::ptrdiff_t>(k));
      ends.erase(ends.begin() + static_cast<std::ptrdiff_t>(k));
    }
    runs.push_back(f);
    ends.push_back(std::move(own));
  }
  for (PlanFunction& f : runs) {
    if (edges.size() >= kMost) f.gx = f.gy = {-1, 1};  // there may be more: split
    outline.push(f);
  }
}

// The scan over a box: its triangles' planes.
Coverage scan_over(const ScannedSurface& scan, const CellBox& box, double guard, FaceOver& face,
                   FunctionList& outline) {
  ScannedSurface::Band band;
  const BaseBounds b =
      scan.bounds({box.x - box.hx, box.x + box.hx, box.y - box.hy, box.y + box.hy}, band);
  if (b.coverage == Coverage::kOutside) return b.coverage;
  if (b.coverage == Coverage::kPartly) scan_outline(scan, box, outline);
  face.zx = b.zx;
  face.zy = b.zy;
  face.c = band.c;
  face.gx = band.gx;
  face.gy = band.gy;
  face.lo = band.rest.lo - guard;
  face.hi = band.rest.hi + guard;
  const double reach = std::fabs(band.gx) * box.hx + std::fabs(band.gy) * box.hy;
  if (b.z.hi - b.z.lo < 2 * reach + face.hi - face.lo) {
    face.c = 0.5 * (b.z.lo + b.z.hi);
    face.gx = face.gy = 0;
    face.hi = 0.5 * (b.z.hi - b.z.lo) + guard;
    face.lo = -face.hi;
  }
  return b.coverage;
}

}  // namespace

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
    if (f.lo <= slack) out.shadow.push(f);
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
    Range above{-kInf, kInf};
    if (between) {
      above = range_of({l.c - mid.c, l.gx - mid.gx, l.gy - mid.gy}, box);
      if (!cap_is_upper) above = scale(above, -1);
    }
    const bool one_root =
        !between;  // the only root lies on the other side of the body than the cap
    const double tiny = s.disc_slack + slack;
    bool outside = false, borders = false;
    if (one_root) {
      outside = r.f.hi < -tiny;
      borders = r.f.lo <= tiny;
    } else {
      outside = r.f.hi < -tiny && above.hi < -slack;
      borders = r.f.lo <= tiny && r.f.hi >= -tiny && above.lo <= slack;
    }
    if (borders && !outside) out.shadow.push(r.f);
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

Coverage base_over(const Impl& surface, const CompoundStep& step, const CellBox& box,
                   FaceOver& face, FunctionList& outline) {
  face = FaceOver{};
  face.label = make_label(step.first_row, 0);
  if (const PlaneSurface* plane = std::get_if<PlaneSurface>(&surface.base)) {
    BaseHit hit;
    plane->at(box.x, box.y, hit);
    face.c = hit.z;
    face.gx = hit.zx;
    face.gy = hit.zy;
    face.zx = {hit.zx, hit.zx};
    face.zy = {hit.zy, hit.zy};
    return Coverage::kInside;
  }
  if (const ScannedSurface* scan = std::get_if<ScannedSurface>(&surface.base)) {
    return scan_over(*scan, box, std::ldexp(surface.size, -44), face, outline);
  }
  const FergusonSurface* ferguson = std::get_if<FergusonSurface>(&surface.base);
  if (ferguson == nullptr) return Coverage::kOutside;
  BaseBounds b = ferguson->bounds({box.x - box.hx, box.x + box.hx, box.y - box.hy, box.y + box.hy});
  if (b.coverage == Coverage::kOutside) return b.coverage;
  if (b.coverage == Coverage::kPartly) {
    // The enclosure is wider than the patch it encloses: the border itself tells.
    const int before = outline.count;
    for (const BaseBorderPiece& piece : surface.base_border) {
      if (piece.box.x0 > box.x + box.hx || piece.box.x1 < box.x - box.hx ||
          piece.box.y0 > box.y + box.hy || piece.box.y1 < box.y - box.hy) {
        continue;
      }
      PlanFunction f;
      f.kind = PlanFunction::Kind::kOutline;
      f.id = piece.side;
      f.gx = piece.nx;
      f.gy = piece.ny;
      f.cgx = 0.5 * (piece.nx.lo + piece.nx.hi);
      f.cgy = 0.5 * (piece.ny.lo + piece.ny.hi);
      f.v = f.cgx * (box.x - piece.x) + f.cgy * (box.y - piece.y);
      f.lo = -kInf;
      f.hi = kInf;
      f.bend = piece.straight ? 0 : kInf;
      if (piece.straight) {
        const double reach = std::fabs(f.cgx) * box.hx + std::fabs(f.cgy) * box.hy;
        if (f.v - reach > piece.close || f.v + reach < -piece.close) continue;
      }
      bool merged = false;
      for (int i = before; i < outline.count; ++i) {
        PlanFunction& g = outline[i];
        if (g.id != f.id) continue;  // pieces of one side follow one another: one curve
        g.gx = {std::fmin(g.gx.lo, f.gx.lo), std::fmax(g.gx.hi, f.gx.hi)};
        g.gy = {std::fmin(g.gy.lo, f.gy.lo), std::fmax(g.gy.hi, f.gy.hi)};
        merged = true;
      }
      if (!merged) outline.push(f);
    }
    if (outline.count == before) {
      BaseHit hit;
      FergusonHint hint;
      b.coverage = ferguson->at(box.x, box.y, hit, hint) ? Coverage::kInside : Coverage::kOutside;
      if (b.coverage == Coverage::kOutside) return b.coverage;
    }
  }
  face.zx = b.zx;
  face.zy = b.zy;
  BaseHit hit;
  FergusonHint hint;
  const double guard = std::ldexp(surface.size, -44);
  if (b.coverage == Coverage::kInside && ferguson->at(box.x, box.y, hit, hint)) {
    face.c = hit.z;
    face.gx = hit.zx;
    face.gy = hit.zy;
    const double bend =
        0.5 * std::fmax(std::fabs(b.zxx.lo), std::fabs(b.zxx.hi)) * box.hx * box.hx +
        0.5 * std::fmax(std::fabs(b.zyy.lo), std::fabs(b.zyy.hi)) * box.hy * box.hy +
        std::fmax(std::fabs(b.zxy.lo), std::fabs(b.zxy.hi)) * box.hx * box.hy;
    const double reach = std::fabs(hit.zx) * box.hx + std::fabs(hit.zy) * box.hy;
    face.lo = -bend - guard;
    face.hi = bend + guard;
    if (!(bend < kInf) || b.z.hi - b.z.lo < 2 * (bend + reach)) {
      if (!(bend < kInf)) {
        face.c = 0.5 * (b.z.lo + b.z.hi);
        face.gx = face.gy = 0;
        face.hi = 0.5 * (b.z.hi - b.z.lo) + guard;
        face.lo = -face.hi;
      }
    }
    return b.coverage;
  }
  face.c = 0.5 * (b.z.lo + b.z.hi);
  face.hi = 0.5 * (b.z.hi - b.z.lo) + guard;
  face.lo = -face.hi;
  return b.coverage;
}

namespace {

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
  p.v = q.v;
  p.gx = q.gx;
  p.gy = q.gy;
  p.lo = q.lo;
  p.hi = q.hi;
  p.cgx = q.cgx;
  p.cgy = q.cgy;
  p.bend = q.bend;
  return true;
}

}  // namespace

bool sides_run_apart(const Impl& surface, const FaceOver& f, const FaceOver& g,
                     const CellBox& box) {
  if (!f.side || !g.side || !f.has_mid || !g.has_mid || !f.tangent || !g.tangent) return false;
  PlanFunction q;
  return pencil_over(surface, f, g, box, q) && (q.lo > 0 || q.hi < 0);
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
  if (implicit != nullptr) {
    p.implicit_side = true;
    p.implicit_label = implicit->label;
    const SideQuadratic& s = surface.bodies[static_cast<std::size_t>(implicit->solid)].side();
    const double dx = box.x - s.cx, dy = box.y - s.cy;
    const bool planar = height->solid >= 0 ? !height->side : false;
    if (planar || (height->solid < 0 && height->lo == 0 && height->hi == 0)) {
      const PlanFunction q = function_of(side_on(s, dx, dy, {height->c, height->gx, height->gy}),
                                         box, PlanFunction::Kind::kCrossing, f.solid, 0);
      p.v = q.v;
      p.gx = q.gx;
      p.gy = q.gy;
      p.lo = q.lo;
      p.hi = q.hi;
      p.cgx = q.cgx;
      p.cgy = q.cgy;
      p.bend = q.bend;
      return p;
    }
    const double reach = std::fabs(height->gx) * box.hx + std::fabs(height->gy) * box.hy;
    const double t = height->c - s.cz;
    const SideGradient r =
        side_gradient(s, dx, dy, box, {t - reach + height->lo, t + reach + height->hi});
    p.gx = add(r.x, times(r.t, height->zx));
    p.gy = add(r.y, times(r.t, height->zy));
    p.lo = -kInf;
    p.hi = kInf;
    p.bend = kInf;
    if (f.side && g.side && f.has_mid && g.has_mid) {
      PlanFunction q = p;
      if (pencil_over(surface, f, g, box, q)) {
        q.implicit_side = false;
        // Elsewhere than over the whole box a side that does not meet the other may still be the
        // higher of the two here and be gone there.
        if (!f.tangent || !g.tangent) q.lo = -kInf, q.hi = kInf;
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
  return p;
}

}  // namespace diesink
