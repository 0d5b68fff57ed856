// BodyLine::meet() and the Boolean rules, several points at a time. The operations and their order
// are those of core/compound/body_line.cpp and compound_surface.cpp; tests/core/row_test.cpp
// compares the digits.
// SPDX-License-Identifier: Apache-2.0
#include "core/compound/row_kernels.h"

#include <cmath>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/compound/row_kernels.cpp"
#include "core/simd.h"

HWY_BEFORE_NAMESPACE();
namespace diesink {
namespace HWY_NAMESPACE {
namespace rows {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::ScalableTag<double>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;
using DL = hn::ScalableTag<std::uint64_t>;
using L = hn::Vec<DL>;

HWY_INLINE V set(double v) { return hn::Set(D(), v); }
HWY_INLINE L set_label(std::uint64_t v) { return hn::Set(DL(), v); }
HWY_INLINE L choose(M mask, L yes, L no) {
  return hn::IfThenElse(hn::RebindMask(DL(), mask), yes, no);
}

// Several points from `at` on; fewer than a vector holds only at the end of a run.
class Points {
 public:
  HWY_INLINE Points(std::size_t at, std::size_t end)
      : at_(at), left_(end - at), full_(left_ >= hn::Lanes(D())) {}

  HWY_INLINE V load(const double* from) const {
    if (HWY_LIKELY(full_)) return hn::LoadU(D(), from + at_);
    return hn::MaskedLoad(hn::FirstN(D(), left_), D(), from + at_);
  }
  HWY_INLINE L load(const std::uint64_t* from) const {
    if (HWY_LIKELY(full_)) return hn::LoadU(DL(), from + at_);
    return hn::MaskedLoad(hn::FirstN(DL(), left_), DL(), from + at_);
  }
  HWY_INLINE void store(V v, double* to) const {
    if (HWY_LIKELY(full_)) {
      hn::StoreU(v, D(), to + at_);
    } else {
      hn::BlendedStore(v, hn::FirstN(D(), left_), D(), to + at_);
    }
  }
  HWY_INLINE void store(L v, std::uint64_t* to) const {
    if (HWY_LIKELY(full_)) {
      hn::StoreU(v, DL(), to + at_);
    } else {
      hn::BlendedStore(v, hn::FirstN(DL(), left_), DL(), to + at_);
    }
  }

 private:
  std::size_t at_, left_;
  bool full_;
};

// The rule of the expression. An undefined z is NaN, which no comparison holds for: an added height
// takes it, a subtracted one does not.
template <bool kPlus>
HWY_INLINE void take(const Points& points, const RowState& state, M met, V e, L label, V tie) {
  const V z = points.load(state.z);
  M takes;
  if constexpr (kPlus) {
    takes = hn::AndNot(e <= z + tie, met);
  } else {
    takes = hn::And(e < z - tie, met);
  }
  if (hn::AllFalse(D(), takes)) return;
  points.store(hn::IfThenElse(takes, e, z), state.z);
  points.store(choose(takes, label, points.load(state.label)), state.label);
}

struct Roots {
  V first, last;
};

HWY_INLINE Roots roots(V q2, V q1, V q0, V disc) {
  const V zero = hn::Zero(D());
  const V s = hn::Sqrt(disc);
  const V m = hn::IfThenElse(q1 >= zero, q1 + s, q1 - s);
  const V far = hn::Neg(m) / q2;
  const M some = m != zero;
  const V near = hn::IfThenElse(some, hn::Neg(q0), hn::Neg(q1)) / hn::IfThenElse(some, m, q2);
  return {hn::Min(far, near), hn::Max(far, near)};
}

template <RowSide kSide, bool kPlus>
void body_run(const BodyRow& b, const double* xs, std::size_t begin, std::size_t end,
              const RowState& state) {
  const D d;
  const V infinity = set(std::numeric_limits<double>::infinity());
  const V zero = hn::Zero(d);
  const V tie = set(b.tie), slack = set(b.slack);
  // A quadric without caps is met wherever its discriminant allows: its lower end is never above
  // its upper.
  const bool closed_side = kSide == RowSide::kBetween && b.uppers == 0 && b.lowers == 0;
  for (std::size_t k = begin; k < end; k += hn::Lanes(d)) {
    const Points points(k, end);
    const V dx = points.load(xs) - set(b.cx);
    M met = hn::FirstN(d, end - k);
    for (std::size_t h = 0; h < b.halves; ++h) {
      const RowHalf& half = b.half[h];
      met = hn::AndNot((set(half.a) * dx + set(half.b_dy)) + set(half.c) > slack, met);
    }
    V lower = hn::Neg(infinity), upper = infinity;
    if constexpr (kSide != RowSide::kNone) {
      const V q0 =
          (set(b.c0) + dx * ((set(b.cx1) + set(b.cxx) * dx) + set(b.cxy_dy))) + set(b.c_dy);
      if constexpr (kSide == RowSide::kColumn) {
        met = hn::AndNot(q0 > set(b.disc_slack), met);
      } else {
        V disc = (set(b.d0) + dx * ((set(b.dx1) + set(b.dxx) * dx) + set(b.dxy_dy))) + set(b.d_dy);
        if constexpr (kSide == RowSide::kBetween || kSide == RowSide::kParaboloidAbove ||
                      kSide == RowSide::kParaboloidBelow) {
          met = hn::AndNot(disc < set(-b.disc_slack), met);
        }
        if (hn::AllFalse(d, met)) continue;
        disc = hn::IfThenElse(disc < zero, zero, disc);
        V first = lower, last = upper;
        if constexpr (kSide == RowSide::kParaboloidAbove) {
          first = hn::Neg(q0) / set(b.b0_twice);
        } else if constexpr (kSide == RowSide::kParaboloidBelow) {
          last = hn::Neg(q0) / set(b.b0_twice);
        } else {
          const V q1 = (set(b.b0) + set(b.bx) * dx) + set(b.by_dy);
          if constexpr (kSide == RowSide::kBetween) {
            const Roots r = roots(set(b.q2), q1, q0, disc);
            first = r.first;
            last = r.last;
          } else if constexpr (kSide == RowSide::kBelowFirst) {
            last = roots(set(b.q2), q1, q0, disc).first;
          } else if constexpr (kSide == RowSide::kAboveLast) {
            first = roots(set(b.q2), q1, q0, disc).last;
          } else {
            // Beside the apex' own side of the plan: the apex, or nothing.
            constexpr bool kBelow = kSide == RowSide::kBelowFirstLinear;
            const V nothing = kBelow ? hn::Neg(infinity) : infinity;
            const V root =
                hn::IfThenElse(kBelow ? q1 > zero : q1 < zero, hn::Neg(q0) / (set(2.0) * q1),
                               hn::IfThenElse(q0 > set(b.disc_slack), nothing, zero));
            (kBelow ? last : first) = root;
          }
        }
        lower = set(b.cz) + first;
        upper = set(b.cz) + last;
      }
    }
    L label = set_label(b.side_label);
    for (std::size_t c = 0; c < b.uppers; ++c) {
      const RowCap& cap = b.upper[c];
      const V z = (set(cap.z0) + set(cap.zx) * dx) + set(cap.zy_dy);
      const M below = z < upper;
      upper = hn::IfThenElse(below, z, upper);
      if constexpr (kPlus) label = choose(below, set_label(cap.label), label);
    }
    for (std::size_t c = 0; c < b.lowers; ++c) {
      const RowCap& cap = b.lower[c];
      const V z = (set(cap.z0) + set(cap.zx) * dx) + set(cap.zy_dy);
      const M above = z > lower;
      lower = hn::IfThenElse(above, z, lower);
      if constexpr (!kPlus) label = choose(above, set_label(cap.label), label);
    }
    if (!closed_side) met = hn::AndNot(lower > upper + slack, met);
    V e = kPlus ? upper : lower;
    e = hn::IfThenElse(e < set(b.z_low), set(b.z_low), e);
    e = hn::IfThenElse(set(b.z_high) < e, set(b.z_high), e);
    take<kPlus>(points, state, met, e, label, tie);
  }
}

template <RowSide kSide>
HWY_INLINE void signed_run(const BodyRow& b, const double* xs, std::size_t begin, std::size_t end,
                           const RowState& state) {
  if (b.plus) {
    body_run<kSide, true>(b, xs, begin, end, state);
  } else {
    body_run<kSide, false>(b, xs, begin, end, state);
  }
}

}  // namespace rows

void body_kernel(const BodyRow& b, const double* xs, std::size_t begin, std::size_t end,
                 const RowState& state) {
  using rows::signed_run;
  switch (b.side) {
    case RowSide::kNone:
      return signed_run<RowSide::kNone>(b, xs, begin, end, state);
    case RowSide::kBetween:
      return signed_run<RowSide::kBetween>(b, xs, begin, end, state);
    case RowSide::kParaboloidAbove:
      return signed_run<RowSide::kParaboloidAbove>(b, xs, begin, end, state);
    case RowSide::kParaboloidBelow:
      return signed_run<RowSide::kParaboloidBelow>(b, xs, begin, end, state);
    case RowSide::kBelowFirst:
      return signed_run<RowSide::kBelowFirst>(b, xs, begin, end, state);
    case RowSide::kBelowFirstLinear:
      return signed_run<RowSide::kBelowFirstLinear>(b, xs, begin, end, state);
    case RowSide::kAboveLast:
      return signed_run<RowSide::kAboveLast>(b, xs, begin, end, state);
    case RowSide::kAboveLastLinear:
      return signed_run<RowSide::kAboveLastLinear>(b, xs, begin, end, state);
    case RowSide::kColumn:
      return signed_run<RowSide::kColumn>(b, xs, begin, end, state);
  }
}

void heights_kernel(const double* z, const std::uint64_t* label, std::size_t begin, std::size_t end,
                    double tie, const RowState& state) {
  using namespace rows;
  for (std::size_t k = begin; k < end; k += hn::Lanes(D())) {
    const Points points(k, end);
    const V e = points.load(z);
    take<true>(points, state, e == e, e, points.load(label), set(tie));
  }
}

void base_kernel(const double* z, std::uint64_t label, bool plus, std::size_t begin,
                 std::size_t end, double tie, const RowState& state) {
  using namespace rows;
  for (std::size_t k = begin; k < end; k += hn::Lanes(D())) {
    const Points points(k, end);
    const V e = points.load(z);
    if (plus) {
      take<true>(points, state, e == e, e, set_label(label), set(tie));
    } else {
      take<false>(points, state, e == e, e, set_label(label), set(tie));
    }
  }
}

void slope_kernel(const double* zx, const double* zy, std::size_t count, double* nx, double* ny,
                  double* nz) {
  using namespace rows;
  const V one = set(1);
  for (std::size_t k = 0; k < count; k += hn::Lanes(D())) {
    const Points points(k, count);
    const V a = points.load(zx), b = points.load(zy);
    const V up = one / hn::Sqrt((a * a + b * b) + one);
    points.store(hn::Neg(a) * up, nx);
    points.store(hn::Neg(b) * up, ny);
    points.store(up, nz);
  }
}

void quadric_kernel(const QuadricGradient& g, const double* xs, double y, const double* z,
                    std::size_t count, double* nx, double* ny, double* nz) {
  using namespace rows;
  const V zero = hn::Zero(D()), one = set(1);
  const V dy = set(y - g.centre[1]);
  for (std::size_t k = 0; k < count; k += hn::Lanes(D())) {
    const Points points(k, count);
    const V dx = points.load(xs) - set(g.centre[0]), dz = points.load(z) - set(g.centre[2]);
    const V gx = ((set(g.m[0]) * dx + set(g.m[1]) * dy) + set(g.m[2]) * dz) + set(g.linear[0]);
    const V gy = ((set(g.m[1]) * dx + set(g.m[3]) * dy) + set(g.m[4]) * dz) + set(g.linear[1]);
    const V gz = ((set(g.m[2]) * dx + set(g.m[4]) * dy) + set(g.m[5]) * dz) + set(g.linear[2]);
    const V square = (gx * gx + gy * gy) + gz * gz;
    const M some = square > zero;
    const V length = hn::Sqrt(square);
    const V scale = hn::IfThenElse(gz < zero, set(-1), one) / length;
    points.store(hn::IfThenElse(some, gx * scale, set(g.at_zero[0])), nx);
    points.store(hn::IfThenElse(some, gy * scale, set(g.at_zero[1])), ny);
    points.store(hn::IfThenElse(some, gz * scale, set(g.at_zero[2])), nz);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace diesink
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace diesink {

HWY_EXPORT(body_kernel);
HWY_EXPORT(heights_kernel);
HWY_EXPORT(base_kernel);
HWY_EXPORT(slope_kernel);
HWY_EXPORT(quadric_kernel);

void apply_body(const BodyRow& body, const double* xs, std::size_t begin, std::size_t end,
                const RowState& state) {
  HWY_DYNAMIC_DISPATCH(body_kernel)(body, xs, begin, end, state);
}

void apply_heights(const double* z, const std::uint64_t* label, std::size_t begin, std::size_t end,
                   double tie, const RowState& state) {
  HWY_DYNAMIC_DISPATCH(heights_kernel)(z, label, begin, end, tie, state);
}

void apply_base(const double* z, std::uint64_t label, bool plus, std::size_t begin, std::size_t end,
                double tie, const RowState& state) {
  HWY_DYNAMIC_DISPATCH(base_kernel)(z, label, plus, begin, end, tie, state);
}

void slope_normals(const double* zx, const double* zy, std::size_t count, double* nx, double* ny,
                   double* nz) {
  HWY_DYNAMIC_DISPATCH(slope_kernel)(zx, zy, count, nx, ny, nz);
}

void quadric_normals(const QuadricGradient& g, const double* xs, double y, const double* z,
                     std::size_t count, double* nx, double* ny, double* nz) {
  HWY_DYNAMIC_DISPATCH(quadric_kernel)(g, xs, y, z, count, nx, ny, nz);
}

}  // namespace diesink
#endif  // HWY_ONCE
