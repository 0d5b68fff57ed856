// Ferguson composite surface: the patches and the inversion of the plan map.
// Source: Choi et al. 1988, steps (b) and (f); Scherrer and Hillberry, CAD 10(5), 1978, for the way
// from patch to patch.
// SPDX-License-Identifier: Apache-2.0
#include "core/base/ferguson.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/base/ferguson_impl.h"
#include "core/interval.h"

namespace diesink {
namespace {

constexpr int kMostNewtonSteps = 10;

// A plan grid that departs from an affine one by less than this part of its size is one: the
// rounding of the coordinates as they were written.
constexpr double kAffineRounding = 0x1p-50;

// A Newton step below this part of a patch is the last: what it leaves is its square, and the
// slopes, taken where it starts, are off by no more than the patch bends over it.
constexpr double kLastStep = 0x1p-37;

// Samples a span of the outline where it is tested for crossing itself.
constexpr int kOutlineSamples = 8;

// Border lines belong to the surface within this part of the largest coordinate.
constexpr double kClosedBorder = 1e-12;

// Slopes of the C2 cubic spline with natural ends through n values at unit spacing, by elimination.
void spline_slopes(const double* values, double* slopes, std::size_t n, std::size_t stride,
                   double* work) {
  const auto p = [&](std::size_t i) { return values[i * stride]; };
  // Row 0: 2 d0 + d1 = 3 (p1 - p0); row i: d(i-1) + 4 d(i) + d(i+1) = 3 (p(i+1) - p(i-1)).
  double pivot = 2;
  slopes[0] = 3 * (p(1) - p(0)) / pivot;
  for (std::size_t i = 1; i < n; ++i) {
    const bool last = i + 1 == n;
    work[i] = 1 / pivot;
    pivot = (last ? 2 : 4) - work[i];
    const double right = last ? 3 * (p(i) - p(i - 1)) : 3 * (p(i + 1) - p(i - 1));
    slopes[i * stride] = (right - slopes[(i - 1) * stride]) / pivot;
  }
  for (std::size_t i = n - 1; i-- > 0;)
    slopes[i * stride] -= work[i + 1] * slopes[(i + 1) * stride];
}

std::optional<AffinePlan> affine_plan(const FergusonBase& base) {
  const std::size_t m = static_cast<std::size_t>(base.columns),
                    n = static_cast<std::size_t>(base.rows);
  const Vec2 origin = base.points.front().head<2>();
  const Vec2 eu = (base.points[m - 1].head<2>() - origin) / static_cast<double>(m - 1);
  const Vec2 ev = (base.points[(n - 1) * m].head<2>() - origin) / static_cast<double>(n - 1);
  double size = 0;
  for (const Vec3& p : base.points) size = std::max({size, std::fabs(p.x()), std::fabs(p.y())});
  for (std::size_t j = 0; j < n; ++j) {
    for (std::size_t i = 0; i < m; ++i) {
      const Vec2 off = base.points[j * m + i].head<2>() -
                       (origin + static_cast<double>(i) * eu + static_cast<double>(j) * ev);
      if (off.cwiseAbs().maxCoeff() > kAffineRounding * size) return std::nullopt;
    }
  }
  const double det = eu.x() * ev.y() - eu.y() * ev.x();
  if (std::fabs(det) <= 1e-9 * eu.norm() * ev.norm()) return std::nullopt;
  // + 0.0: no negative zeros, so that an axis-parallel grid has none in its heights either.
  return AffinePlan{origin.x(),          origin.y(),          ev.y() / det + 0.0,
                    -ev.x() / det + 0.0, -eu.y() / det + 0.0, eu.x() / det + 0.0};
}

}  // namespace

void FergusonSurface::make_patches(const FergusonBase& base) {
  const std::size_t m = static_cast<std::size_t>(columns_), n = static_cast<std::size_t>(rows_);
  std::vector<double> value(m * n), along_u(m * n), along_v(m * n), work(std::max(m, n));
  patches_.resize((m - 1) * (n - 1));
  for (int k = 0; k < 3; ++k) {
    for (std::size_t i = 0; i < m * n; ++i) value[i] = base.points[i][k];
    for (std::size_t j = 0; j < n; ++j)
      spline_slopes(&value[j * m], &along_u[j * m], m, 1, work.data());
    for (std::size_t i = 0; i < m; ++i) spline_slopes(&value[i], &along_v[i], n, m, work.data());
    for (std::size_t j = 0; j + 1 < n; ++j) {
      for (std::size_t i = 0; i + 1 < m; ++i) {
        double p[2][2], ps[2][2], pt[2][2];
        for (std::size_t a = 0; a < 2; ++a) {
          for (std::size_t b = 0; b < 2; ++b) {
            const std::size_t at = (j + b) * m + i + a;
            p[a][b] = value[at];
            ps[a][b] = along_u[at];
            pt[a][b] = along_v[at];
          }
        }
        FergusonPatch& patch = patches_[j * (m - 1) + i];
        (k == 0 ? patch.x : k == 1 ? patch.y : patch.z) = Bicubic::hermite(p, ps, pt);
      }
    }
  }
  plan_box_ = {INFINITY, -INFINITY, INFINITY, -INFINITY};
  for (FergusonPatch& patch : patches_) {
    const BicubicOver x(patch.x, {}), y(patch.y, {});
    const Range rx = x.range(0, 0), ry = y.range(0, 0);
    const double xs = x.middle(1, 0), xt = x.middle(0, 1), ys = y.middle(1, 0), yt = y.middle(0, 1);
    // The patch's least plan breadth, which turns lengths into parameters.
    const double breadth =
        std::fabs(xs * yt - xt * ys) / std::max(std::hypot(xs, ys), std::hypot(xt, yt));
    const double close = kClosedBorder * size_;
    patch.closeness = std::min(close / breadth, 1e-3);
    patch.convergence = std::clamp(0x1p-48 * size_ / breadth, kLastStep, 1e-4);
    patch.box = {rx.lo - close, rx.hi + close, ry.lo - close, ry.hi + close};
    plan_box_ = {std::min(plan_box_.x0, patch.box.x0), std::max(plan_box_.x1, patch.box.x1),
                 std::min(plan_box_.y0, patch.box.y0), std::max(plan_box_.y1, patch.box.y1)};
  }
}

void FergusonSurface::make_bins() {
  // About two bins a patch each way, so that a bin names a few patches only.
  const auto bins = [](int spans) { return std::clamp(2 * spans, 1, 1024); };
  bins_x_ = bins(columns_ - 1);
  bins_y_ = bins(rows_ - 1);
  bin_ix_ = bins_x_ / (plan_box_.x1 - plan_box_.x0);
  bin_iy_ = bins_y_ / (plan_box_.y1 - plan_box_.y0);
  const auto column = [&](double x) {
    return std::clamp(static_cast<int>((x - plan_box_.x0) * bin_ix_), 0, bins_x_ - 1);
  };
  const auto line = [&](double y) {
    return std::clamp(static_cast<int>((y - plan_box_.y0) * bin_iy_), 0, bins_y_ - 1);
  };
  bin_start_.assign(static_cast<std::size_t>(bins_x_) * static_cast<std::size_t>(bins_y_) + 1, 0);
  const auto each = [&](const auto& visit) {
    for (std::uint32_t p = 0; p < patches_.size(); ++p) {
      const PlanBox& b = patches_[p].box;
      for (int j = line(b.y0); j <= line(b.y1); ++j) {
        for (int i = column(b.x0); i <= column(b.x1); ++i) {
          visit(static_cast<std::size_t>(j) * static_cast<std::size_t>(bins_x_) +
                    static_cast<std::size_t>(i),
                p);
        }
      }
    }
  };
  each([&](std::size_t bin, std::uint32_t) { ++bin_start_[bin + 1]; });
  for (std::size_t b = 1; b < bin_start_.size(); ++b) bin_start_[b] += bin_start_[b - 1];
  bin_items_.resize(bin_start_.back());
  std::vector<std::uint32_t> next(bin_start_.begin(), bin_start_.end() - 1);
  each([&](std::size_t bin, std::uint32_t p) { bin_items_[next[bin]++] = p; });
}

Result<FergusonSurface> FergusonSurface::make(const FergusonBase& base) {
  Result<FergusonSurface> out = with_patches(base);
  if (out && !out->affine_) {
    out->make_inverses();
    out->make_bins();
  }
  return out;
}

Status FergusonSurface::check_plan(const FergusonBase& base) {
  const Result<FergusonSurface> out = with_patches(base);
  return out ? ok() : Status(out.error());
}

Result<FergusonSurface> FergusonSurface::with_patches(const FergusonBase& base) {
  assert(base.columns >= 2 && base.rows >= 2);
  assert(base.points.size() ==
         static_cast<std::size_t>(base.columns) * static_cast<std::size_t>(base.rows));
  FergusonSurface out;
  out.columns_ = base.columns;
  out.rows_ = base.rows;
  for (const Vec3& p : base.points) out.size_ = std::max(out.size_, p.cwiseAbs().maxCoeff());
  out.affine_ = affine_plan(base);
  out.make_patches(base);
  if (out.affine_) {
    const AffinePlan& a = *out.affine_;
    out.turned_ = a.ux * a.vy - a.uy * a.vx < 0;
    out.u_close_ = std::min(kClosedBorder * out.size_ * std::hypot(a.ux, a.uy), 1e-3);
    out.v_close_ = std::min(kClosedBorder * out.size_ * std::hypot(a.vx, a.vy), 1e-3);
    return out;
  }
  const BicubicOver x(out.patches_[0].x, {}), y(out.patches_[0].y, {});
  const double jacobian = x.middle(1, 0) * y.middle(0, 1) - x.middle(0, 1) * y.middle(1, 0);
  out.turned_ = jacobian < 0;
  for (std::size_t p = 0; p < out.patches_.size(); ++p) {
    if (unfolded(out.patches_[p], out.turned_)) continue;
    const std::size_t i = p % static_cast<std::size_t>(base.columns - 1),
                      j = p / static_cast<std::size_t>(base.columns - 1);
    return Error{ErrorCode::kInput,
                 "the base surface is folded or collapsed in plan in the patch from point " +
                     std::to_string(i + 1) + " of row " + std::to_string(j + 1) +
                     "; expected points whose patches lie side by side in plan",
                 base.where};
  }
  // One sign of the Jacobian and an outline that does not cross itself: no plan point has two feet.
  std::vector<Vec2> outline;
  for (int side = 0; side < 4; ++side) {
    const int steps = kOutlineSamples * static_cast<int>(out.border_length(side));
    for (int k = 0; k < steps; ++k) {
      outline.push_back(out.border(side, static_cast<double>(k) / kOutlineSamples).at);
    }
  }
  if (const std::optional<Vec2> at = outline_crossing(outline)) {
    return Error{ErrorCode::kInput,
                 "the base surface overlaps itself in plan: its border crosses itself near x " +
                     std::to_string(at->x()) + ", y " + std::to_string(at->y()) +
                     "; expected one point of the base over each plan point",
                 base.where};
  }
  return out;
}

bool FergusonSurface::affine_foot(double x, double y, FergusonFoot& foot) const {
  const AffinePlan& a = *affine_;
  const double u = a.ux * (x - a.x0) + a.uy * (y - a.y0);
  const double v = a.vx * (x - a.x0) + a.vy * (y - a.y0);
  if (!(u >= -u_close_ && u <= columns_ - 1 + u_close_ && v >= -v_close_ &&
        v <= rows_ - 1 + v_close_))
    return false;
  const int i = span_of(u, columns_), j = span_of(v, rows_);
  foot.s = u - i;
  foot.t = v - j;
  foot.patch = static_cast<std::uint32_t>(j * patch_columns() + i);
  return true;
}

std::span<const std::uint32_t> FergusonSurface::patches_near(double x, double y) const {
  if (!(x >= plan_box_.x0 && x <= plan_box_.x1 && y >= plan_box_.y0 && y <= plan_box_.y1))
    return {};
  const int i = std::clamp(static_cast<int>((x - plan_box_.x0) * bin_ix_), 0, bins_x_ - 1);
  const int j = std::clamp(static_cast<int>((y - plan_box_.y0) * bin_iy_), 0, bins_y_ - 1);
  const std::size_t bin =
      static_cast<std::size_t>(j) * static_cast<std::size_t>(bins_x_) + static_cast<std::size_t>(i);
  return std::span(bin_items_).subspan(bin_start_[bin], bin_start_[bin + 1] - bin_start_[bin]);
}

namespace {

// Newton's method from the foot's (s, t) until a step is rounding; false where it does not get
// there.
bool iterate(const FergusonPatch& p, double x, double y, FergusonFoot& foot) {
  for (int k = 0; k < kMostNewtonSteps; ++k) {
    const scalar::NewtonStep<double> n =
        scalar::newton_step(p, x, y, foot.s, foot.t, scalar::Lift{});
    foot.s += n.ds;
    foot.t += n.dt;
    if (std::fabs(n.ds) <= p.convergence && std::fabs(n.dt) <= p.convergence) {
      foot.plan = n.slopes;
      return true;
    }
    if (!(std::fabs(foot.s) < kFarOutside && std::fabs(foot.t) < kFarOutside)) return false;
  }
  return false;
}

bool in_patch(const FergusonPatch& p, const FergusonFoot& foot) {
  return foot.s >= -p.closeness && foot.s <= 1 + p.closeness && foot.t >= -p.closeness &&
         foot.t <= 1 + p.closeness;
}

}  // namespace

bool FergusonSurface::invert_in(std::uint32_t patch, double x, double y, FergusonFoot& foot) const {
  const InversePatch& inverse = inverses_[patch];
  foot.patch = patch;
  scalar::start_at(inverse, scalar::inverse_line(inverse, y), x, scalar::Lift{}, foot.s, foot.t);
  return iterate(patches_[patch], x, y, foot) && in_patch(patches_[patch], foot);
}

bool FergusonSurface::invert_surely(std::uint32_t patch, double x, double y,
                                    FergusonFoot& foot) const {
  const FergusonPatch& p = patches_[patch];
  ParameterBoxes pieces;
  preimage(p, {x, x, y, y}, pieces);
  foot.patch = patch;
  for (const ParameterBox& piece : pieces.items()) {
    foot.s = 0.5 * (piece.s0 + piece.s1);
    foot.t = 0.5 * (piece.t0 + piece.t1);
    if (iterate(p, x, y, foot) && in_patch(p, foot)) return true;
  }
  return false;
}

bool FergusonSurface::invert_patch(double x, double y, std::int32_t hint,
                                   FergusonFoot& foot) const {
  if (hint >= 0) {
    // Well inside a patch there is no other that the search below could find.
    const auto patch = static_cast<std::uint32_t>(hint);
    if (invert_in(patch, x, y, foot) && well_inside(patches_[patch], foot.s, foot.t)) return true;
  }
  const std::span<const std::uint32_t> near = patches_near(x, y);
  for (const bool surely : {false, true}) {
    for (const std::uint32_t p : near) {
      const PlanBox& b = patches_[p].box;
      if (!(x >= b.x0 && x <= b.x1 && y >= b.y0 && y <= b.y1)) continue;
      if (surely ? invert_surely(p, x, y, foot) : invert_in(p, x, y, foot)) return true;
    }
  }
  return false;
}

bool FergusonSurface::at(double x, double y, BaseHit& hit, FergusonHint& hint) const {
  FergusonFoot foot;
  if (affine_) {
    if (!affine_foot(x, y, foot)) return false;
  } else if (!invert_patch(x, y, hint.patch, foot)) {
    return false;
  }
  const FergusonPatch& p = patches_[foot.patch];
  const scalar::PatchValue<double> z =
      scalar::value_at(scalar::line_at(p.z, foot.t, scalar::Lift{}), foot.s, scalar::Lift{});
  const scalar::PlanSlope<double> slope = affine_
                                              ? scalar::affine_slope(z, *affine_, scalar::Lift{})
                                              : scalar::warped_slope(z, foot.plan);
  hit = {z.f, slope.zx, slope.zy, 0};
  hint.patch = static_cast<std::int32_t>(foot.patch);
  hint.u = static_cast<int>(foot.patch) % patch_columns() + foot.s;
  hint.v = static_cast<int>(foot.patch) / patch_columns() + foot.t;
  return true;
}

std::optional<Vec2> FergusonSurface::invert(double x, double y) const {
  BaseHit hit;
  FergusonHint hint;
  if (!at(x, y, hit, hint)) return std::nullopt;
  return Vec2(std::clamp(hint.u, 0.0, columns_ - 1.0), std::clamp(hint.v, 0.0, rows_ - 1.0));
}

FergusonSurface::Point FergusonSurface::point(double u, double v) const {
  u = std::clamp(u, 0.0, columns_ - 1.0);
  v = std::clamp(v, 0.0, rows_ - 1.0);
  const int i = span_of(u, columns_), j = span_of(v, rows_);
  const FergusonPatch& p = patch(i, j);
  Point out;
  const Bicubic* const coordinates[3] = {&p.x, &p.y, &p.z};
  for (int k = 0; k < 3; ++k) {
    const scalar::PatchValue<double> f = scalar::value_at(
        scalar::line_at(*coordinates[k], v - j, scalar::Lift{}), u - i, scalar::Lift{});
    out.r[k] = f.f;
    out.ru[k] = f.fs;
    out.rv[k] = f.ft;
  }
  return out;
}

double FergusonSurface::border_length(int side) const {
  return ((side & 1) != 0) == turned_ ? columns_ - 1 : rows_ - 1;
}

FergusonSurface::BorderPoint FergusonSurface::border(int side, double w) const {
  // Anticlockwise in parameters, and the mirror of that where the plan is turned over.
  const double m = columns_ - 1, n = rows_ - 1;
  const bool by_u = ((side & 1) != 0) == turned_;
  const bool back = side >= 2;
  double u, v;
  if (by_u) {
    u = back ? m - w : w;
    v = (side == 0 || side == 3) ? 0 : n;
  } else {
    v = back ? n - w : w;
    u = (side == 0 || side == 3) ? 0 : m;
  }
  const Point p = point(u, v);
  const Vec2 along = (by_u ? p.ru : p.rv).head<2>();
  return {p.r.head<2>(), back ? Vec2(-along) : along};
}

}  // namespace diesink
