// Ferguson surfaces along a row: patch by patch, several points at a time, by run-time dispatch to
// the machine's vectors. The arithmetic is that of the point evaluation, operation by operation, so
// the digits are the same.
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstddef>
#include <limits>

#include "core/base/ferguson_impl.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/base/ferguson_row.cpp"
#include "core/simd.h"

#ifndef DIESINK_FERGUSON_ROW_REACH
#define DIESINK_FERGUSON_ROW_REACH
namespace diesink {

// How many points a run wrote, and where the next lies in the parameters of the run's patch.
struct RowReach {
  std::size_t written;
  double s, t;
};

}  // namespace diesink
#endif

HWY_BEFORE_NAMESPACE();
namespace diesink {
namespace HWY_NAMESPACE {
namespace ferguson {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::ScalableTag<double>;
using V = hn::Vec<D>;

struct Lift {
  HWY_INLINE V operator()(double v) const { return hn::Set(D(), v); }
};
#define DIESINK_INLINE HWY_INLINE
#include "core/base/ferguson_formulas-inl.h"
#undef DIESINK_INLINE

struct RowOut {
  double* z;
  double* zx;
  double* zy;
};

HWY_INLINE void store(const RowOut& out, std::size_t at, std::size_t left, V z, V zx, V zy) {
  const D d;
  if (left >= hn::Lanes(d)) {
    hn::StoreU(z, d, out.z + at);
    hn::StoreU(zx, d, out.zx + at);
    hn::StoreU(zy, d, out.zy + at);
    return;
  }
  const auto some = hn::FirstN(d, left);
  hn::BlendedStore(z, some, d, out.z + at);
  hn::BlendedStore(zx, some, d, out.zx + at);
  hn::BlendedStore(zy, some, d, out.zy + at);
}

HWY_INLINE V load(const double* from, std::size_t left) {
  const D d;
  return left >= hn::Lanes(d) ? hn::LoadU(d, from) : hn::MaskedLoad(hn::FirstN(d, left), d, from);
}

// A run inside one patch of an affine grid: u = ux (x - x0) + u_row, v likewise.
void affine_run(const FergusonPatch& p, const AffinePlan& a, double u_row, double v_row, double i,
                double j, const double* xs, std::size_t count, const RowOut& out) {
  const D d;
  const Lift lift;
  // Where v does not change along the row, neither do the cubics in s.
  const bool level = a.vx == 0;
  PatchLine<V> line = line_at(p.z, lift(v_row - j), lift);
  const V zero = hn::Zero(d);
  for (std::size_t k = 0; k < count; k += hn::Lanes(d)) {
    const V dx = load(xs + k, count - k) - lift(a.x0);
    const V s = (lift(a.ux) * dx + lift(u_row)) - lift(i);
    if (!level) line = line_at(p.z, (lift(a.vx) * dx + lift(v_row)) - lift(j), lift);
    const PatchValue<V> z = value_at(line, s, lift);
    PlanSlope<V> slope = affine_slope(z, a, lift);
    store(out, k, count - k, z.f, slope.zx + zero, slope.zy);
  }
}

// A run along one y that starts in one patch of a warped grid; returns how many points from its
// first on lie well inside the patch and are written.
RowReach warped_run(const FergusonPatch& p, const InversePatch& inverse, double y, const double* xs,
                    std::size_t count, const RowOut& out) {
  const D d;
  const Lift lift;
  const InverseLine start = inverse_line(inverse, y);
  const V py = lift(y), small = lift(p.convergence);
  const V low = lift(1e-6 + 4 * p.closeness), high = lift(1 - (1e-6 + 4 * p.closeness));
  for (std::size_t k = 0; k < count; k += hn::Lanes(d)) {
    const std::size_t left = std::min(count - k, hn::Lanes(d));
    const V px = load(xs + k, left);
    V s, t;
    start_at(inverse, start, px, lift, s, t);
    // Lanes stop one by one, each after the steps that its point alone would take.
    auto going = hn::FirstN(d, left);
    NewtonStep<V> n = newton_step(p, px, py, s, t, lift);
    PlanSlopes<V> plan = n.slopes;
    for (int step = 1;; ++step) {
      s = hn::IfThenElse(going, s + n.ds, s);
      t = hn::IfThenElse(going, t + n.dt, t);
      plan = {
          hn::IfThenElse(going, n.slopes.xs, plan.xs), hn::IfThenElse(going, n.slopes.xt, plan.xt),
          hn::IfThenElse(going, n.slopes.ys, plan.ys), hn::IfThenElse(going, n.slopes.yt, plan.yt),
          hn::IfThenElse(going, n.slopes.inverse, plan.inverse)};
      const auto still = hn::And(hn::Abs(n.ds) <= small, hn::Abs(n.dt) <= small);
      going = hn::AndNot(still, going);
      if (hn::AllFalse(d, going) || step == 6) break;
      n = newton_step(p, px, py, s, t, lift);
    }
    const auto inside = hn::And(hn::And(s > low, s < high), hn::And(t > low, t < high));
    const auto good = hn::AndNot(going, inside);
    const PatchValue<V> z = value_at(line_at(p.z, t, lift), s, lift);
    const PlanSlope<V> slope = warped_slope(z, plan);
    const std::intptr_t bad = hn::FindFirstTrue(d, hn::Not(good));
    const std::size_t written = bad < 0 ? left : std::min(left, static_cast<std::size_t>(bad));
    store(out, k, written, z.f, slope.zx, slope.zy);
    if (written < left) {
      double at_s[hn::MaxLanes(D())], at_t[hn::MaxLanes(D())];
      hn::StoreU(s, d, at_s);
      hn::StoreU(t, d, at_t);
      return {k + written, at_s[written], at_t[written]};
    }
  }
  return {count, 0.5, 0.5};
}

}  // namespace ferguson

void ferguson_affine_run(const FergusonPatch& p, const AffinePlan& a, double u_row, double v_row,
                         double i, double j, const double* xs, std::size_t count, double* z,
                         double* zx, double* zy) {
  ferguson::affine_run(p, a, u_row, v_row, i, j, xs, count, {z, zx, zy});
}

RowReach ferguson_warped_run(const FergusonPatch& p, const InversePatch& inverse, double y,
                             const double* xs, std::size_t count, double* z, double* zx,
                             double* zy) {
  return ferguson::warped_run(p, inverse, y, xs, count, {z, zx, zy});
}

}  // namespace HWY_NAMESPACE
}  // namespace diesink
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace diesink {

HWY_EXPORT(ferguson_affine_run);
HWY_EXPORT(ferguson_warped_run);

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

}  // namespace

std::int32_t FergusonSurface::beside(std::int32_t patch, double s, double t) const {
  const auto step = [](double w) { return w > 0.5 ? (w > 1 - 1e-5 ? 1 : 0) : (w < 1e-5 ? -1 : 0); };
  const int i = patch % patch_columns() + step(s), j = patch / patch_columns() + step(t);
  if (i < 0 || i > columns_ - 2 || j < 0 || j > rows_ - 2) return -1;
  return j * patch_columns() + i;
}

void FergusonSurface::row(double y, std::span<const double> xs, double* z, double* zx,
                          double* zy) const {
  const auto point = [&](std::size_t k, FergusonHint& hint) {
    BaseHit hit;
    const bool found = at(xs[k], y, hit, hint);
    z[k] = found ? hit.z : kNaN;
    zx[k] = hit.zx;
    zy[k] = hit.zy;
    return found;
  };
  if (!affine_) {
    const auto run = [&](std::int32_t patch, std::size_t k) {
      const auto p = static_cast<std::size_t>(patch);
      return HWY_DYNAMIC_DISPATCH(ferguson_warped_run)(patches_[p], inverses_[p], y, xs.data() + k,
                                                       xs.size() - k, z + k, zx + k, zy + k);
    };
    std::int32_t patch = -1;
    for (std::size_t k = 0; k < xs.size();) {
      if (patch >= 0) {
        const RowReach reach = run(patch, k);
        k += reach.written;
        if (reach.written > 0) {
          patch = beside(patch, reach.s, reach.t);
          continue;
        }
      }
      // On a line between patches, or astray: the point by itself.
      FergusonHint hint;
      patch = point(k, hint) ? hint.patch : -1;
      ++k;
    }
    return;
  }
  const AffinePlan& a = *affine_;
  const double u_row = a.uy * (y - a.y0), v_row = a.vy * (y - a.y0);
  for (std::size_t k = 0; k < xs.size();) {
    FergusonFoot foot;
    if (!affine_foot(xs[k], y, foot)) {
      z[k] = kNaN;
      zx[k] = zy[k] = 0;
      ++k;
      continue;
    }
    // Parameters move one way along the row, rounding included, so that the patch's points are all
    // in one run.
    std::size_t end = k + 1, beyond = xs.size();
    FergusonFoot other;
    const auto same = [&](std::size_t q) {
      return affine_foot(xs[q], y, other) && other.patch == foot.patch;
    };
    // Doubling steps, then halving: neighbouring points share a patch far more often than not.
    for (std::size_t step = 8; end < beyond; step *= 2) {
      const std::size_t probe = std::min(end + step, beyond) - 1;
      if (!same(probe)) {
        beyond = probe;
        break;
      }
      end = probe + 1;
    }
    while (end < beyond) {
      const std::size_t middle = end + (beyond - end) / 2;
      if (same(middle)) {
        end = middle + 1;
      } else {
        beyond = middle;
      }
    }
    const int patch = static_cast<int>(foot.patch);
    HWY_DYNAMIC_DISPATCH(ferguson_affine_run)
    (patches_[foot.patch], a, u_row, v_row, patch % patch_columns(), patch / patch_columns(),
     xs.data() + k, end - k, z + k, zx + k, zy + k);
    k = end;
  }
}

}  // namespace diesink
#endif  // HWY_ONCE
