// SPDX-License-Identifier: Apache-2.0
#include "core/mesh_tools/exact_space.h"

#include <array>
#include <cstddef>

#include "core/base/exact_plan.h"

namespace diesink {
namespace {

// A sum without rounding: parts that do not overlap, the largest last.
class Expansion {
 public:
  // Adds x * y * z.
  void add(double x, double y, double z) {
    const TwoWords xy = two_product(x, y);
    for (const double part : {xy.low, xy.high}) {
      const TwoWords product = two_product(part, z);
      grow(product.low);
      grow(product.high);
    }
  }
  [[nodiscard]] int sign() const { return count_ == 0 ? 0 : parts_[count_ - 1] > 0 ? 1 : -1; }

 private:
  void grow(double number) {
    if (number == 0) return;
    double carry = number;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      const TwoWords sum = two_sum(carry, parts_[i]);
      if (sum.low != 0) parts_[kept++] = sum.low;
      carry = sum.high;
    }
    if (carry != 0) parts_[kept++] = carry;
    count_ = kept;
  }

  std::array<double, 96> parts_;  // of 24 products of four words each
  std::size_t count_ = 0;
};

// Adds the determinant of a, b, c, or takes it away.
void add_determinant(Expansion& sum, double sign, const Vec3& a, const Vec3& b, const Vec3& c) {
  for (int k = 0; k < 3; ++k) {
    const int l = (k + 1) % 3, m = (k + 2) % 3;
    sum.add(sign * a[k], b[l], c[m]);
    sum.add(-sign * a[k], b[m], c[l]);
  }
}

bool exact_difference(const Vec3& a, const Vec3& b, Vec3& difference) {
  for (int k = 0; k < 3; ++k) {
    const TwoWords part = two_difference(a[k], b[k]);
    if (part.low != 0) return false;
    difference[k] = part.high;
  }
  return true;
}

}  // namespace

int exact_side(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  Expansion sum;
  // Coordinates of files are mostly near enough to one another, and short enough.
  Vec3 ad, bd, cd;
  if (exact_difference(a, d, ad) && exact_difference(b, d, bd) && exact_difference(c, d, cd)) {
    add_determinant(sum, 1, ad, bd, cd);
    return sum.sign();
  }
  // Multiplied out, as determinants with two rows d are 0.
  add_determinant(sum, 1, a, b, c);
  add_determinant(sum, -1, d, b, c);
  add_determinant(sum, -1, a, d, c);
  add_determinant(sum, -1, a, b, d);
  return sum.sign();
}

}  // namespace diesink
