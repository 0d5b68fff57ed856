// SPDX-License-Identifier: Apache-2.0
#include "core/base/exact_plan.h"

#include <array>
#include <cstddef>

namespace diesink {

int exact_turn(double ax, double ay, double bx, double by, double cx, double cy) {
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
