// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/coincidence.h"

#include <algorithm>
#include <cmath>

namespace diesink {
namespace {

using Impl = CompoundSurface::Impl;

bool height_at(const Impl& surface, const FaceOver& f, const CellBox& box, double dx, double dy,
               double& z) {
  if (f.solid < 0) {
    BaseHit hit;
    if (!surface.base_at(box.x + dx, box.y + dy, hit)) return false;
    z = hit.z;
    return true;
  }
  if (f.side) {
    return surface.bodies[static_cast<std::size_t>(f.solid)].face_height(f.face, f.upper,
                                                                         box.x + dx, box.y + dy, z);
  }
  z = f.c + f.gx * dx + f.gy * dy;
  return true;
}

// The face over a part of the box; false for a side.
bool face_on(const Impl& surface, const FaceOver& f, const CellBox& box, const CellBox& part,
             FaceOver& out) {
  if (f.side) return false;
  if (f.solid < 0) {
    const CompoundStep& step =
        surface.steps[surface.step_of_row[static_cast<std::size_t>(row_of(f.label))]];
    FunctionList outline;
    return base_over(surface, step, part, out, outline) != Coverage::kOutside;
  }
  out = FaceOver{};
  out.gx = f.gx;
  out.gy = f.gy;
  out.c = f.c + f.gx * (part.x - box.x) + f.gy * (part.y - box.y);
  out.lo = f.lo;
  out.hi = f.hi;
  return true;
}

bool is_straight_along_axis(const PlanFunction& f) {
  return f.kind != PlanFunction::Kind::kCrossing && f.bend == 0 && (f.cgx == 0) != (f.cgy == 0);
}

// `line` is straight and parallel to an axis.
bool vanishes_along(const Impl& surface, const PlanFunction& line, const PlanFunction& crossing,
                    const FaceOver& f, const FaceOver& g, const CellBox& box) {
  CellBox part = box;
  const Range& across = line.cgy == 0 ? crossing.gx : crossing.gy;
  if (!(across.lo > 0 || across.hi < 0)) return false;
  if (line.cgy == 0) {
    part.x -= line.v / line.cgx;
    part.hx = 0;
    if (std::fabs(part.x - box.x) > box.hx) return false;
  } else {
    part.y -= line.v / line.cgy;
    part.hy = 0;
    if (std::fabs(part.y - box.y) > box.hy) return false;
  }
  FaceOver on_f, on_g;
  const bool has_f = face_on(surface, f, box, part, on_f);
  const bool has_g = face_on(surface, g, box, part, on_g);
  Range d;
  double least = kLineSlack * surface.tie;
  if (has_f && has_g) {
    d = difference_over(on_f, on_g, part);
  } else if (has_f != has_g && crossing.implicit_side) {
    // On the line the form is as far from zero as its gradient times what the two are apart.
    d = side_form_over(surface, has_f ? g : f, has_f ? on_f : on_g, part);
    least *= std::fmin(std::fabs(across.lo), std::fabs(across.hi));
  } else {
    return false;
  }
  return std::fmax(std::fabs(d.lo), std::fabs(d.hi)) <= least;
}

}  // namespace

bool touches_from_above(const Impl& surface, const FaceOver& f, const FaceOver& g,
                        const CellBox& box) {
  if (f.side && g.side) {
    return surface.contacts.is_above({f.solid, f.has_mid && f.upper, f.has_mid && !f.upper},
                                     {g.solid, g.has_mid && g.upper, g.has_mid && !g.upper});
  }
  const auto is_plane = [](const FaceOver& face) {
    return !face.side && (face.solid >= 0 || (face.lo == 0 && face.hi == 0));
  };
  // (Less than evaluation's, lest a cell be plain that shows another label in its corner.)
  const double slack = (1 - kEnclosureSlack) * kLineSlack * surface.tie;
  const ContactReach reach{box.hx + box.hy, box.hx + box.hy};
  if (f.side && f.has_mid && is_plane(g)) {
    const BodyLine& body = surface.bodies[static_cast<std::size_t>(f.solid)];
    return side_of_tangent_plane(body, {box.x, box.y, g.c}, g.gx, g.gy, reach, slack) < 0;
  }
  if (g.side && g.has_mid && is_plane(f)) {
    const BodyLine& body = surface.bodies[static_cast<std::size_t>(g.solid)];
    return side_of_tangent_plane(body, {box.x, box.y, f.c}, f.gx, f.gy, reach, slack) > 0;
  }
  return false;
}

bool covers_steep_face(const Impl& surface, const FaceOver& f, const FaceOver& g,
                       const CellBox& box) {
  constexpr double kSteep = 1e3;
  if (f.upper != g.upper) return false;
  const FaceOver &side = f.upper ? f : g, &plane = f.upper ? g : f;
  if (!side.has_mid || plane.side || plane.solid < 0) return false;
  const double steep = std::hypot(plane.gx, plane.gy);
  if (!(steep > kSteep)) return false;
  const BodyLine& body = surface.bodies[static_cast<std::size_t>(plane.solid)];
  const double up = side.upper ? 1 : -1;
  const double x = box.x - body.center_x(), y = box.y - body.center_y();
  for (const PlanarCap& cap : side.upper ? body.upper_caps() : body.lower_caps()) {
    if (cap.face == plane.face) continue;
    const double beyond = up * (side.mc - (cap.z0 + cap.zx * x + cap.zy * y)) -
                          std::fabs(side.mgx - cap.zx) * box.hx -
                          std::fabs(side.mgy - cap.zy) * box.hy;
    if (beyond >= -(1 - kEnclosureSlack) * steep * surface.tie) return true;
  }
  return false;
}

bool rises_above(const Impl& surface, const FaceOver& f, const FaceOver& g, const CellBox& box) {
  const double width = f.hi - f.lo + g.hi - g.lo;
  if (!(width > 0) || !(f.c - g.c > surface.tie) || (f.side && !f.tangent) ||
      (g.side && !g.tangent))
    return false;
  const Range d = difference_over(f, g, box);
  if (!(d.lo + width >= -surface.tie)) return false;  // the least value is no larger than this
  const Range dx{f.zx.lo - g.zx.hi, f.zx.hi - g.zx.lo}, dy{f.zy.lo - g.zy.hi, f.zy.hi - g.zy.lo};
  if (!((dx.lo >= 0 || dx.hi <= 0) && (dy.lo >= 0 || dy.hi <= 0))) return false;
  const double x = dx.lo >= 0 ? -box.hx : box.hx, y = dy.lo >= 0 ? -box.hy : box.hy;
  // Along a whole side of the box a tie is no crossing; in its corner alone it would be one for
  // evaluation, which gives that point to the earlier of the two, and a line ends there.
  const bool one_corner = (dx.lo > 0 || dx.hi < 0) && (dy.lo > 0 || dy.hi < 0);
  double zf = 0, zg = 0;
  return height_at(surface, f, box, x, y, zf) && height_at(surface, g, box, x, y, zg) &&
         (one_corner ? zf - zg > 2 * surface.tie : zf - zg >= -surface.tie);
}

bool drop_crossings_along_lines(const Impl& surface, const CellBox& box, CellVerdict& verdict) {
  if (std::none_of(verdict.functions.begin(), verdict.functions.end(), is_straight_along_axis))
    return false;
  const auto face_of_label = [&](Label label) {
    return std::find_if(verdict.candidates.begin(), verdict.candidates.end(),
                        [&](const FaceOver& f) { return f.label == label; });
  };
  FunctionList kept;
  for (const PlanFunction& p : verdict.functions) {
    bool dropped = false;
    if (p.kind == PlanFunction::Kind::kCrossing && p.regular()) {
      const FaceOver *f = face_of_label(p.a), *g = face_of_label(p.b);
      for (const PlanFunction& line : verdict.functions) {
        dropped = dropped ||
                  (is_straight_along_axis(line) && f != verdict.candidates.end() &&
                   g != verdict.candidates.end() && vanishes_along(surface, line, p, *f, *g, box));
      }
    }
    if (!dropped) kept.push(p);
  }
  if (kept.count == verdict.functions.count) return false;
  verdict.functions = kept;
  return true;
}

}  // namespace diesink
