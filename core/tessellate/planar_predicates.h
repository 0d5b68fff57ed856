// Signs of the two determinants of plane triangulation, exact on a lattice of whole numbers.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

namespace diesink {

// A point of the lattice.
// Needs: both are whole numbers with magnitude at most 2^52, so that the difference of two
// coordinates is a double without rounding.
struct LatticePoint {
  double x = 0, y = 0;
};

inline bool operator==(const LatticePoint& p, const LatticePoint& q) {
  return p.x == q.x && p.y == q.y;
}

// The same signs by whole-number arithmetic alone: slow, for what the filters below leave open.
int exact_orientation(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c);
int exact_in_circle(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c,
                    const LatticePoint& d);

// 1 where a, b, c turn anticlockwise, -1 clockwise, 0 in one line. Exact.
inline int orientation(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c) {
  const double left = (a.x - c.x) * (b.y - c.y);
  const double right = (a.y - c.y) * (b.x - c.x);
  const double det = left - right;
  // Two products and a difference, each rounded once: less than 2^-52 of the sum; doubled.
  const double bound = 0x1p-51 * (std::abs(left) + std::abs(right));
  if (det > bound) return 1;
  if (det < -bound) return -1;
  return exact_orientation(a, b, c);
}

// 1 where d lies inside the circle through the anticlockwise triangle a, b, c; -1 outside; 0 on
// it. Exact.
inline int in_circle(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c,
                     const LatticePoint& d) {
  const double ax = a.x - d.x, ay = a.y - d.y;
  const double bx = b.x - d.x, by = b.y - d.y;
  const double cx = c.x - d.x, cy = c.y - d.y;
  const double bc1 = bx * cy, bc2 = cx * by;
  const double ca1 = cx * ay, ca2 = ax * cy;
  const double ab1 = ax * by, ab2 = bx * ay;
  const double a2 = ax * ax + ay * ay, b2 = bx * bx + by * by, c2 = cx * cx + cy * cy;
  const double det = a2 * (bc1 - bc2) + b2 * (ca1 - ca2) + c2 * (ab1 - ab2);
  // At most six roundings on the way to each of the six terms, of 2^-53 each; with room to spare.
  const double bound =
      0x1p-49 * (a2 * (std::abs(bc1) + std::abs(bc2)) + b2 * (std::abs(ca1) + std::abs(ca2)) +
                 c2 * (std::abs(ab1) + std::abs(ab2)));
  if (det > bound) return 1;
  if (det < -bound) return -1;
  return exact_in_circle(a, b, c, d);
}

}  // namespace diesink
