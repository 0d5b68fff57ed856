// SPDX-License-Identifier: Apache-2.0
#include "core/base/bicubic.h"

#include <cmath>

#include "core/interval.h"

namespace diesink {
namespace {

// Factor of x^(k-a) in the a-th derivative of x^k.
constexpr double kFalling[3][4] = {{1, 1, 1, 1}, {0, 1, 2, 3}, {0, 0, 2, 6}};

// Hermite to power basis along one direction: value and slope at 0 and at 1.
void to_powers(double p0, double p1, double d0, double d1, double out[4]) {
  const double rise = p1 - p0;
  out[0] = p0;
  out[1] = d0;
  out[2] = 3 * rise - 2 * d0 - d1;
  out[3] = d0 + d1 - 2 * rise;
}

}  // namespace

Bicubic Bicubic::hermite(const double p[2][2], const double ps[2][2], const double pt[2][2]) {
  // Along s first, for the four quantities given along t: value and t-slope at t = 0 and 1.
  double value0[4], value1[4], slope0[4], slope1[4];
  to_powers(p[0][0], p[1][0], ps[0][0], ps[1][0], value0);
  to_powers(p[0][1], p[1][1], ps[0][1], ps[1][1], value1);
  to_powers(pt[0][0], pt[1][0], 0, 0, slope0);
  to_powers(pt[0][1], pt[1][1], 0, 0, slope1);
  Bicubic out;
  for (std::size_t k = 0; k < 4; ++k) {
    to_powers(value0[k], value1[k], slope0[k], slope1[k], out.c[k].data());
  }
  return out;
}

double Bicubic::at(double s, double t) const {
  double sum = 0;
  for (std::size_t k = 4; k-- > 0;) {
    const std::array<double, 4>& r = c[k];
    sum = sum * s + (((r[3] * t + r[2]) * t + r[1]) * t + r[0]);
  }
  return sum;
}

BicubicOver::BicubicOver(const Bicubic& polynomial, const ParameterBox& box)
    : hs_(0.5 * (box.s1 - box.s0)), ht_(0.5 * (box.t1 - box.t0)) {
  const double s = 0.5 * (box.s0 + box.s1), t = 0.5 * (box.t0 + box.t1);
  double sum = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    const std::array<double, 4>& r = polynomial.c[k];
    const double r32 = r[3] * t;
    c_[k][0] = ((r32 + r[2]) * t + r[1]) * t + r[0];
    c_[k][1] = (3 * r32 + 2 * r[2]) * t + r[1];
    c_[k][2] = 3 * r32 + r[2];
    c_[k][3] = r[3];
    sum += std::fabs(r[0]) + std::fabs(r[1]) + std::fabs(r[2]) + std::fabs(r[3]);
  }
  for (int l = 0; l < 4; ++l) {
    const double r0 = c_[0][l], r1 = c_[1][l], r2 = c_[2][l], r3 = c_[3][l];
    c_[0][l] = ((r3 * s + r2) * s + r1) * s + r0;
    c_[1][l] = (3 * r3 * s + 2 * r2) * s + r1;
    c_[2][l] = 3 * r3 * s + r2;
    c_[3][l] = r3;
  }
  // Some thirty roundings, each of at most half an ulp of nine times the sum; boxes whose ends lie
  // up to one rounding outside the unit square are covered as well.
  rounding_ = sum * 0x1p-45;
  // The middle is rounded: the half sizes must still reach both ends.
  hs_ += 0x1p-53;
  ht_ += 0x1p-53;
}

double BicubicOver::middle(int a, int b) const {
  return c_[a][b] * kFalling[a][a] * kFalling[b][b];
}

namespace {

// Sums over the middle's neighbours in the power basis: what even powers add, either way, and what
// odd powers may.
struct Spread {
  double even_lo = 0, even_hi = 0, odd = 0;
};

template <int A, int B>
Spread spread(const double (&c)[4][4], double hs, double ht) {
  Spread sum;
  double s_power = 1;
  for (int k = A; k < 4; ++k, s_power *= hs) {
    double power = s_power * kFalling[A][k];
    for (int l = B; l < 4; ++l, power *= ht) {
      if (k == A && l == B) continue;
      const double term = c[k][l] * kFalling[B][l] * power;
      if (((k - A) | (l - B)) & 1) {
        sum.odd += std::fabs(term);
      } else {
        sum.even_hi += term > 0 ? term : 0;
        sum.even_lo += term > 0 ? 0 : term;
      }
    }
  }
  return sum;
}

}  // namespace

Range BicubicOver::range(int a, int b) const {
  // Each order on its own, so that what is odd and even in it is known to the compiler.
  static constexpr decltype(&spread<0, 0>) kOf[3][3] = {{spread<0, 0>, spread<0, 1>, spread<0, 2>},
                                                        {spread<1, 0>, spread<1, 1>, spread<1, 2>},
                                                        {spread<2, 0>, spread<2, 1>, spread<2, 2>}};
  const Spread sum = kOf[a][b](c_, hs_, ht_);
  const double m = middle(a, b);
  return widened(m + sum.even_lo - sum.odd, m + sum.even_hi + sum.odd, rounding_);
}

}  // namespace diesink
