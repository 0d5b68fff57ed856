// A bicubic polynomial over the unit square, one coordinate of a patch, with certain bounds.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "core/base/base_surface.h"

namespace diesink {

// Part of the unit square of a patch's parameters.
struct ParameterBox {
  double s0 = 0, s1 = 1, t0 = 0, t1 = 1;
};

// sum over k, l of c[k][l] s^k t^l, 0 <= k, l <= 3.
struct Bicubic {
  std::array<std::array<double, 4>, 4> c{};

  // From corner values and tangents, twists zero (paper, step (b)): p[i][j] at s = i, t = j.
  static Bicubic hermite(const double p[2][2], const double ps[2][2], const double pt[2][2]);

  [[nodiscard]] double at(double s, double t) const;
};

// The same polynomial in powers of the distance from the middle of a parameter box: an exact form
// whose lower terms are the derivatives there and whose higher terms bound what the polynomial does
// in the box.
class BicubicOver {
 public:
  BicubicOver(const Bicubic& polynomial, const ParameterBox& box);

  // d^(a+b) / ds^a dt^b at the middle of the box. Needs: 0 <= a, b <= 2.
  [[nodiscard]] double middle(int a, int b) const;

  // Its enclosure over the box.
  // Bound: as wide as the range itself but for terms of second order in the box's size.
  [[nodiscard]] Range range(int a, int b) const;

 private:
  double c_[4][4];
  double hs_, ht_;
  double rounding_;  // bound of what rounding can do to any coefficient sum
};

}  // namespace diesink
