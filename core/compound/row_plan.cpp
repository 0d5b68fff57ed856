// SPDX-License-Identifier: Apache-2.0
#include "core/compound/row_plan.h"

#include <cassert>
#include <cmath>

#include "core/interval.h"

namespace diesink {
namespace {

constexpr Range kNowhere{1, -1};

// Part of `range` where a x + c >= 0.
void keep_nonnegative(double a, double c, Range& range) {
  if (a > 0) {
    range.lo = std::max(range.lo, -c / a);
  } else if (a < 0) {
    range.hi = std::min(range.hi, -c / a);
  } else if (c < 0) {
    range = kNowhere;
  }
}

// Part of `range` where a x² + b x + c >= 0, for a < 0: between the roots. Otherwise nothing is cut
// off.
void keep_between_roots(double a, double b, double c, Range& range) {
  if (!(a < 0)) return;
  const double disc = b * b - 4 * a * c;
  if (disc < 0) {
    // Rounding of a row that grazes the shadow must not lose it.
    if (disc < -1e-9 * (b * b + std::fabs(4 * a * c))) {
      range = kNowhere;
      return;
    }
  }
  const double s = std::sqrt(std::max(disc, 0.0) + 1e-13 * (b * b + std::fabs(4 * a * c)));
  const double lo = (-b + s) / (2 * a), hi = (-b - s) / (2 * a);
  range.lo = std::max(range.lo, lo);
  range.hi = std::min(range.hi, hi);
}

RowSide row_side(const BodyLine& body) {
  if (!body.has_side()) return RowSide::kNone;
  const bool linear = body.side().q2 == 0;
  switch (body.side_rule()) {
    case SideRule::kBetween:
      if (!linear) return RowSide::kBetween;
      return body.side().b0 < 0 ? RowSide::kParaboloidAbove : RowSide::kParaboloidBelow;
    case SideRule::kBelowFirst:
      return linear ? RowSide::kBelowFirstLinear : RowSide::kBelowFirst;
    case SideRule::kAboveLast:
      return linear ? RowSide::kAboveLastLinear : RowSide::kAboveLast;
    case SideRule::kColumn:
      break;
  }
  return RowSide::kColumn;
}

}  // namespace

Range row_span(const BodyLine& body, double y) {
  const PlanBox& box = body.plan_box();
  if (!(y >= box.y0 && y <= box.y1)) return kNowhere;
  const SideQuadratic& s = body.side();
  const double dy = y - s.cy;
  Range dx{box.x0 - s.cx, box.x1 - s.cx};
  for (const PlanHalf& h : body.halves()) keep_nonnegative(-h.a, body.slack() - h.c - h.b * dy, dx);
  if (body.has_side() && body.side_rule() == SideRule::kColumn) {
    keep_between_roots(-s.cxx, -(s.cx1 + s.cxy * dy),
                       s.disc_slack - s.c0 - dy * (s.cy1 + s.cyy * dy), dx);
  } else if (body.has_side() && body.side_rule() == SideRule::kBetween && s.q2 != 0) {
    keep_between_roots(s.dxx, s.dx1 + s.dxy * dy, s.disc_slack + s.d0 + dy * (s.dy1 + s.dyy * dy),
                       dx);
  }
  // Where a lower face rises above an upper one there is no body.
  for (const PlanarCap& u : body.upper_caps()) {
    for (const PlanarCap& l : body.lower_caps()) {
      keep_nonnegative(u.zx - l.zx, (u.z0 - l.z0) + (u.zy - l.zy) * dy + body.slack(), dx);
    }
  }
  if (is_empty(dx)) return kNowhere;
  // Beyond the rounding of all that: the kernel tests every point for itself.
  const double pad = 1e-9 * (box.x1 - box.x0) + 1e-12 * (std::fabs(box.x0) + std::fabs(box.x1));
  return {s.cx + dx.lo - pad, s.cx + dx.hi + pad};
}

void make_body_row(const BodyLine& body, double y, int row, Sign sign, double tie, BodyRow& out) {
  const SideQuadratic& s = body.side();
  const double dy = y - s.cy;
  out.side = row_side(body);
  out.plus = sign == Sign::kPlus;
  out.cx = s.cx;
  out.cz = s.cz;
  out.slack = body.slack();
  out.tie = tie;
  out.z_low = body.z_low();
  out.z_high = body.z_high();
  out.q2 = s.q2;
  out.disc_slack = s.disc_slack;
  out.b0_twice = 2 * s.b0;
  out.b0 = s.b0;
  out.bx = s.bx;
  out.by_dy = s.by * dy;
  out.c0 = s.c0;
  out.cx1 = s.cx1;
  out.cxx = s.cxx;
  out.cxy_dy = s.cxy * dy;
  out.c_dy = dy * (s.cy1 + s.cyy * dy);
  out.d0 = s.d0;
  out.dx1 = s.dx1;
  out.dxx = s.dxx;
  out.dxy_dy = s.dxy * dy;
  out.d_dy = dy * (s.dy1 + s.dyy * dy);
  out.side_label = make_label(row, kFaceSide);
  assert(body.upper_caps().size() <= kMostRowFaces && body.lower_caps().size() <= kMostRowFaces &&
         body.halves().size() <= kMostRowFaces);
  out.uppers = out.lowers = out.halves = 0;
  for (const PlanarCap& c : body.upper_caps())
    out.upper[out.uppers++] = {c.z0, c.zx, c.zy * dy, make_label(row, c.face)};
  for (const PlanarCap& c : body.lower_caps())
    out.lower[out.lowers++] = {c.z0, c.zx, c.zy * dy, make_label(row, c.face)};
  for (const PlanHalf& h : body.halves()) out.half[out.halves++] = {h.a, h.b * dy, h.c};
}

}  // namespace diesink
