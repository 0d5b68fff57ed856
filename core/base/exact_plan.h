// Exact signs in plan for any doubles, and the two-word arithmetic behind them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

namespace diesink {

// The same sign by expansions alone: slow, for what the filter below leaves open.
int exact_turn(double ax, double ay, double bx, double by, double cx, double cy);

// 1 where a, b, c turn anticlockwise, -1 clockwise, 0 in one line. Exact.
// Needs: coordinates that are 0 or of a magnitude between 2^-400 and 2^400.
// Source: Shewchuk, Adaptive precision floating-point arithmetic, 1997.
inline int turn(double ax, double ay, double bx, double by, double cx, double cy) {
  const double left = (ax - cx) * (by - cy);
  const double right = (ay - cy) * (bx - cx);
  const double det = left - right;
  // Three roundings a product and one of the difference, each at most 2^-53 of the sum.
  const double bound = 0x1p-50 * (std::fabs(left) + std::fabs(right));
  if (det > bound) return 1;
  if (det < -bound) return -1;
  return exact_turn(ax, ay, bx, by, cx, cy);
}

struct PlanPoint {
  double x = 0, y = 0;
};

// Whether p comes before q on the way round o, clockwise from `from`, which comes last itself; what
// lies one way is one place. Exact.
// Needs: none of them at o; coordinates as for turn().
inline bool clockwise_before(const PlanPoint& o, const PlanPoint& from, const PlanPoint& p,
                             const PlanPoint& q) {
  const auto part = [&](const PlanPoint& d) {
    const int side = turn(o.x, o.y, from.x, from.y, d.x, d.y);
    if (side != 0) return side < 0 ? 0 : 2;
    const bool ahead =
        from.x != o.x ? (from.x > o.x) == (d.x > o.x) : (from.y > o.y) == (d.y > o.y);
    return ahead ? 3 : 1;
  };
  const int of_p = part(p), of_q = part(q);
  return of_p != of_q ? of_p < of_q : turn(o.x, o.y, p.x, p.y, q.x, q.y) < 0;
}

// The unevaluated sum of two doubles, about 104 bits.
struct TwoWords {
  double high = 0, low = 0;
};

// a + b, a - b and a * b exactly.
inline TwoWords two_sum(double a, double b) {
  const double s = a + b, bb = s - a;
  return {s, (a - (s - bb)) + (b - bb)};
}
inline TwoWords two_difference(double a, double b) { return two_sum(a, -b); }
inline TwoWords two_product(double a, double b) {
  const double p = a * b;
  return {p, std::fma(a, b, -p)};
}

// To about 2^-100 of the larger operand.
inline TwoWords operator+(const TwoWords& a, const TwoWords& b) {
  const TwoWords s = two_sum(a.high, b.high);
  return two_sum(s.high, s.low + (a.low + b.low));
}
inline TwoWords operator-(const TwoWords& a, const TwoWords& b) {
  return a + TwoWords{-b.high, -b.low};
}
inline TwoWords operator*(const TwoWords& a, const TwoWords& b) {
  const TwoWords p = two_product(a.high, b.high);
  return two_sum(p.high, p.low + (a.high * b.low + a.low * b.high));
}
inline double quotient(const TwoWords& a, const TwoWords& b) {
  const double q = a.high / b.high;
  const TwoWords rest = a - TwoWords{q, 0} * b;
  return q + rest.high / b.high;
}

}  // namespace diesink
