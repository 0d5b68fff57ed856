// Interval arithmetic on Range: results contain all results of the operands, rounding included.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "core/base/base_surface.h"

namespace diesink {

constexpr Range point_range(double v) { return {v, v}; }
constexpr Range symmetric(double r) { return {-r, r}; }

// Wider by a little more than one rounding of each end, and by `more` on either side.
inline Range widened(double lo, double hi, double more = 0) {
  constexpr double kUlp = 0x1p-52, kTiny = 0x1p-1050;
  return {lo - (std::fabs(lo) * kUlp + kTiny + more), hi + (std::fabs(hi) * kUlp + kTiny + more)};
}

inline Range operator+(const Range& a, const Range& b) { return widened(a.lo + b.lo, a.hi + b.hi); }
inline Range operator-(const Range& a, const Range& b) { return widened(a.lo - b.hi, a.hi - b.lo); }
inline Range operator-(const Range& a) { return {-a.hi, -a.lo}; }

// Finite operands only.
inline Range operator*(const Range& a, const Range& b) {
  const double p = a.lo * b.lo, q = a.lo * b.hi, r = a.hi * b.lo, s = a.hi * b.hi;
  return widened(std::min(std::min(p, q), std::min(r, s)),
                 std::max(std::max(p, q), std::max(r, s)));
}
inline Range operator*(double a, const Range& b) {
  const double p = a * b.lo, q = a * b.hi;
  return widened(std::min(p, q), std::max(p, q));
}

// 1 / a; the whole line where a contains zero.
inline Range reciprocal(const Range& a) {
  if (a.lo <= 0 && a.hi >= 0) return {};
  return widened(1 / a.hi, 1 / a.lo);
}

inline Range hull(const Range& a, const Range& b) {
  return {std::min(a.lo, b.lo), std::max(a.hi, b.hi)};
}
// May come out empty (lo > hi).
inline Range intersection(const Range& a, const Range& b) {
  return {std::max(a.lo, b.lo), std::min(a.hi, b.hi)};
}
inline bool is_empty(const Range& a) { return !(a.lo <= a.hi); }
inline bool contains(const Range& a, double v) { return a.lo <= v && v <= a.hi; }
inline double magnitude(const Range& a) { return std::max(std::fabs(a.lo), std::fabs(a.hi)); }
inline double width(const Range& a) { return a.hi - a.lo; }

}  // namespace diesink
