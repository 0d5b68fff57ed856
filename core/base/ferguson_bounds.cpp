// Enclosures of a Ferguson surface over plan boxes.
// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "core/base/ferguson_impl.h"
#include "core/interval.h"

namespace diesink {
namespace {

constexpr Range kNothing{INFINITY, -INFINITY};

BaseBounds nothing() {
  BaseBounds out;
  out.coverage = Coverage::kOutside;
  out.z = out.zx = out.zy = out.zxx = out.zxy = out.zyy = kNothing;
  return out;
}

void take(BaseBounds& out, const BaseBounds& part) {
  out.z = hull(out.z, part.z);
  out.zx = hull(out.zx, part.zx);
  out.zy = hull(out.zy, part.zy);
  out.zxx = hull(out.zxx, part.zxx);
  out.zxy = hull(out.zxy, part.zxy);
  out.zyy = hull(out.zyy, part.zyy);
}

// A surface that covers the whole box departs from its height over the middle by no more than its
// slopes allow; across a parameter box that does not follow the axes of the plan this is far
// tighter.
void use_slopes(BaseBounds& out, const PlanBox& box, double z, double rounding) {
  const double hx = 0.5 * (box.x1 - box.x0), hy = 0.5 * (box.y1 - box.y0);
  const double reach = magnitude(out.zx) * hx + magnitude(out.zy) * hy;
  out.z = intersection(out.z, widened(z - reach, z + reach, rounding));
}

// Enclosures over a part of one patch, derivatives in plan by the chain rule.
BaseBounds bounds_over(const FergusonPatch& p, const ParameterBox& part) {
  const BicubicOver x(p.x, part), y(p.y, part), z(p.z, part);
  const Range xs = x.range(1, 0), xt = x.range(0, 1), ys = y.range(1, 0), yt = y.range(0, 1);
  const Range inverse = reciprocal(xs * yt - xt * ys);
  BaseBounds over;
  over.z = z.range(0, 0);
  if (std::isfinite(inverse.lo) && std::isfinite(inverse.hi)) {
    const Range sx = yt * inverse, tx = -ys * inverse, sy = -xt * inverse, ty = xs * inverse;
    const Range zs = z.range(1, 0), zt = z.range(0, 1);
    over.zx = zs * sx + zt * tx;
    over.zy = zs * sy + zt * ty;
    // Twice by the chain rule: what of z's curvature in parameters the plan's own does not
    // explain.
    const auto rest = [&](int a, int b) {
      return z.range(a, b) - over.zx * x.range(a, b) - over.zy * y.range(a, b);
    };
    const Range rss = rest(2, 0), rst = rest(1, 1), rtt = rest(0, 2);
    over.zxx = rss * sx * sx + 2 * (rst * sx * tx) + rtt * tx * tx;
    over.zxy = rss * sx * sy + rst * (sx * ty + sy * tx) + rtt * tx * ty;
    over.zyy = rss * sy * sy + 2 * (rst * sy * ty) + rtt * ty * ty;
  }
  return over;
}

}  // namespace

BaseBounds FergusonSurface::bounds(const PlanBox& box) const {
  return affine_ ? affine_bounds(box) : warped_bounds(box);
}

BaseBounds FergusonSurface::affine_bounds(const PlanBox& box) const {
  const AffinePlan& a = *affine_;
  const Range dx = Range{box.x0, box.x1} - point_range(a.x0),
              dy = Range{box.y0, box.y1} - point_range(a.y0);
  const Range u = a.ux * dx + a.uy * dy, v = a.vx * dx + a.vy * dy;
  const Range all_u{-u_close_, columns_ - 1 + u_close_}, all_v{-v_close_, rows_ - 1 + v_close_};
  const Range in_u = intersection(u, all_u), in_v = intersection(v, all_v);
  BaseBounds out = nothing();
  if (is_empty(in_u) || is_empty(in_v)) return out;
  // What rounding adds to an exact parameter must not make a box that ends on the border a partial
  // one.
  const double slack_u = 0.5 * u_close_, slack_v = 0.5 * v_close_;
  const bool inside = u.lo >= all_u.lo + slack_u && u.hi <= all_u.hi - slack_u &&
                      v.lo >= all_v.lo + slack_v && v.hi <= all_v.hi - slack_v;
  out.coverage = inside ? Coverage::kInside : Coverage::kPartly;
  for (int j = span_of(in_v.lo, rows_); j <= span_of(in_v.hi, rows_); ++j) {
    for (int i = span_of(in_u.lo, columns_); i <= span_of(in_u.hi, columns_); ++i) {
      ParameterBox part{in_u.lo - i, in_u.hi - i, in_v.lo - j, in_v.hi - j};
      // Only what leaves the grid reaches past a patch.
      if (i > 0) part.s0 = std::max(part.s0, 0.0);
      if (i < columns_ - 2) part.s1 = std::min(part.s1, 1.0);
      if (j > 0) part.t0 = std::max(part.t0, 0.0);
      if (j < rows_ - 2) part.t1 = std::min(part.t1, 1.0);
      const BicubicOver z(patch(i, j).z, part);
      const Range zs = z.range(1, 0), zt = z.range(0, 1);
      const Range zss = z.range(2, 0), zst = z.range(1, 1), ztt = z.range(0, 2);
      const auto second = [&](double ua, double va, double ub, double vb) {
        return (ua * ub) * zss + (ua * vb + va * ub) * zst + (va * vb) * ztt;
      };
      BaseBounds over;
      over.z = z.range(0, 0);
      over.zx = a.ux * zs + a.vx * zt;
      over.zy = a.uy * zs + a.vy * zt;
      over.zxx = second(a.ux, a.vx, a.ux, a.vx);
      over.zxy = second(a.ux, a.vx, a.uy, a.vy);
      over.zyy = second(a.uy, a.vy, a.uy, a.vy);
      take(out, over);
    }
  }
  if (inside && (a.uy != 0 || a.vx != 0)) {
    BaseHit hit;
    FergusonHint hint;
    if (at(0.5 * (box.x0 + box.x1), 0.5 * (box.y0 + box.y1), hit, hint)) {
      use_slopes(out, box, hit.z, 1e-14 * size_);
    }
  }
  return out;
}

BaseBounds FergusonSurface::warped_bounds(const PlanBox& box) const {
  BaseBounds out = nothing();
  if (box.x1 < plan_box_.x0 || box.x0 > plan_box_.x1 || box.y1 < plan_box_.y0 ||
      box.y0 > plan_box_.y1)
    return out;
  // A box well inside one patch, the common case: a parameter box about its middle's own into which
  // the contraction falls holds a foot of every point of it, and no point has two.
  FergusonFoot foot;
  const double hx = 0.5 * (box.x1 - box.x0), hy = 0.5 * (box.y1 - box.y0);
  const bool covered = invert_patch(0.5 * (box.x0 + box.x1), 0.5 * (box.y0 + box.y1), -1, foot);
  if (covered) {
    const FergusonPatch& p = patches_[foot.patch];
    const double scale = 1.5 * std::fabs(foot.plan.inverse);
    const double rs =
        scale * (std::fabs(foot.plan.yt) * hx + std::fabs(foot.plan.xt) * hy) + p.closeness;
    const double rt =
        scale * (std::fabs(foot.plan.ys) * hx + std::fabs(foot.plan.xs) * hy) + p.closeness;
    ParameterBox part{foot.s - rs, foot.s + rs, foot.t - rt, foot.t + rt};
    if (part.s0 > 0 && part.s1 < 1 && part.t0 > 0 && part.t1 < 1 && contract_inside(p, box, part)) {
      out = bounds_over(p, part);
      out.coverage = Coverage::kInside;
      use_slopes(out, box, p.z.at(foot.s, foot.t), 1e-13 * size_);
      return out;
    }
  }
  bool at_border = false, any = false;
  const auto visit = [&](std::uint32_t number) {
    const FergusonPatch& p = patches_[number];
    if (box.x1 < p.box.x0 || box.x0 > p.box.x1 || box.y1 < p.box.y0 || box.y0 > p.box.y1) return;
    const int i = static_cast<int>(number) % patch_columns(),
              j = static_cast<int>(number) / patch_columns();
    ParameterBoxes parts;
    preimage(p, box, parts);
    for (const ParameterBox& part : parts.items()) {
      any = true;
      at_border = at_border || (i == 0 && part.s0 <= p.closeness) ||
                  (j == 0 && part.t0 <= p.closeness) ||
                  (i == columns_ - 2 && part.s1 >= 1 - p.closeness) ||
                  (j == rows_ - 2 && part.t1 >= 1 - p.closeness);
      take(out, bounds_over(p, part));
    }
  };
  const auto bin = [](double v, double low, double scale, int count) {
    return std::clamp(static_cast<int>(std::clamp((v - low) * scale, 0.0, 1e6)), 0, count - 1);
  };
  const int i0 = bin(box.x0, plan_box_.x0, bin_ix_, bins_x_),
            i1 = bin(box.x1, plan_box_.x0, bin_ix_, bins_x_);
  const int j0 = bin(box.y0, plan_box_.y0, bin_iy_, bins_y_),
            j1 = bin(box.y1, plan_box_.y0, bin_iy_, bins_y_);
  if (i0 == i1 && j0 == j1) {
    const std::size_t at = static_cast<std::size_t>(j0) * static_cast<std::size_t>(bins_x_) +
                           static_cast<std::size_t>(i0);
    for (std::uint32_t k = bin_start_[at]; k < bin_start_[at + 1]; ++k) visit(bin_items_[k]);
  } else {
    // A patch stands in several bins: once each.
    std::vector<std::uint32_t> found;
    for (int j = j0; j <= j1; ++j) {
      const std::size_t first = static_cast<std::size_t>(j) * static_cast<std::size_t>(bins_x_) +
                                static_cast<std::size_t>(i0);
      const std::size_t last = first + static_cast<std::size_t>(i1 - i0);
      found.insert(found.end(), bin_items_.begin() + bin_start_[first],
                   bin_items_.begin() + bin_start_[last + 1]);
    }
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    for (const std::uint32_t number : found) visit(number);
  }
  if (!any) return out;
  out.coverage = Coverage::kPartly;
  if (at_border) return out;
  // No border crosses the box, so it is covered everywhere or nowhere: its middle decides.
  if (!covered) {
    out.coverage = Coverage::kOutside;
    return out;
  }
  out.coverage = Coverage::kInside;
  use_slopes(out, box, patches_[foot.patch].z.at(foot.s, foot.t), 1e-13 * size_);
  return out;
}

}  // namespace diesink
