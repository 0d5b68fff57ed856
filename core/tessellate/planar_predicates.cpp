// Signs of the two determinants of plane triangulation, exact on a lattice of whole numbers.
// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/planar_predicates.h"

#include <array>
#include <cstdint>

namespace diesink {
namespace {

__extension__ typedef __int128 Int128;
__extension__ typedef unsigned __int128 UInt128;

Int128 difference(double p, double q) {
  return static_cast<std::int64_t>(p) - static_cast<std::int64_t>(q);
}

// A 256-bit two's complement sum of products of 128-bit factors. Coordinates of 2^52 make factors
// below 2^108 and three products below 2^218, far from its end.
class WideSum {
 public:
  void add_product(Int128 p, Int128 q) {
    const bool negative = (p < 0) != (q < 0);
    const UInt128 u = p < 0 ? -static_cast<UInt128>(p) : static_cast<UInt128>(p);
    const UInt128 v = q < 0 ? -static_cast<UInt128>(q) : static_cast<UInt128>(q);
    const UInt128 u0 = low(u), u1 = u >> 64, v0 = low(v), v1 = v >> 64;
    const UInt128 w00 = u0 * v0, w01 = u0 * v1, w10 = u1 * v0, w11 = u1 * v1;
    const UInt128 middle = (w00 >> 64) + low(w01) + low(w10);
    add(low(w00) | (middle << 64), w11 + (w01 >> 64) + (w10 >> 64) + (middle >> 64), negative);
  }

  [[nodiscard]] int sign() const {
    if ((high_ >> 127) != 0) return -1;
    return high_ == 0 && low_ == 0 ? 0 : 1;
  }

 private:
  static UInt128 low(UInt128 v) { return static_cast<std::uint64_t>(v); }

  void add(UInt128 low, UInt128 high, bool negative) {
    if (negative) {
      high_ = high_ - high - (low_ < low ? 1U : 0U);
      low_ -= low;
    } else {
      low_ += low;
      high_ = high_ + high + (low_ < low ? 1U : 0U);
    }
  }

  UInt128 low_ = 0, high_ = 0;
};

}  // namespace

int exact_orientation(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c) {
  const Int128 det =
      difference(a.x, c.x) * difference(b.y, c.y) - difference(a.y, c.y) * difference(b.x, c.x);
  return det > 0 ? 1 : (det < 0 ? -1 : 0);
}

int exact_in_circle(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c,
                    const LatticePoint& d) {
  const Int128 ax = difference(a.x, d.x), ay = difference(a.y, d.y);
  const Int128 bx = difference(b.x, d.x), by = difference(b.y, d.y);
  const Int128 cx = difference(c.x, d.x), cy = difference(c.y, d.y);
  WideSum sum;
  sum.add_product(ax * ax + ay * ay, bx * cy - cx * by);
  sum.add_product(bx * bx + by * by, cx * ay - ax * cy);
  sum.add_product(cx * cx + cy * cy, ax * by - bx * ay);
  return sum.sign();
}

}  // namespace diesink
