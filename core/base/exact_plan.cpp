// SPDX-License-Identifier: Apache-2.0
#include "core/base/exact_plan.h"

#include <array>
#include <cstddef>

namespace diesink {

int exact_turn(double ax, double ay, double bx, double by, double cx, double cy) {
  // Most of what a filter leaves open lies on a lattice, where all differences are exact: then two
  // products of two words each tell.
  const TwoWords acx = two_difference(ax, cx), bcy = two_difference(by, cy),
                 acy = two_difference(ay, cy), bcx = two_difference(bx, cx);
  if (acx.low == 0 && bcy.low == 0 && acy.low == 0 && bcx.low == 0) {
    const TwoWords left = two_product(acx.high, bcy.high), right = two_product(acy.high, bcx.high);
    // Rounding keeps the order.
    if (left.high != right.high) return left.high > right.high ? 1 : -1;
    return left.low != right.low ? (left.low > right.low ? 1 : -1) : 0;
  }
  // The determinant multiplied out: six products of given numbers, of two words each, which no
  // rounding touches. Grown into one expansion its largest part has the sign of the sum.
  const std::array<TwoWords, 6> products{two_product(ax, by),  two_product(-ax, cy),
                                         two_product(-cx, by), two_product(-ay, bx),
                                         two_product(ay, cx),  two_product(cy, bx)};
  std::array<double, 12> parts{};
  std::size_t count = 0;
  for (const TwoWords& product : products) {
    for (const double word : {product.low, product.high}) {
      double carry = word;
      for (std::size_t i = 0; i < count; ++i) {
        const TwoWords sum = two_sum(carry, parts[i]);
        parts[i] = sum.low;
        carry = sum.high;
      }
      parts[count++] = carry;
    }
  }
  for (std::size_t i = count; i-- > 0;) {
    if (parts[i] != 0) return parts[i] > 0 ? 1 : -1;
  }
  return 0;
}

}  // namespace diesink
