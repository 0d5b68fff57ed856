// Quadratic forms of a triangle's edges, which say how far a flat triangle is from what bends.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>

namespace diesink {

// A form q_ij of each edge; [k] is that of the edge opposite vertex k.
using EdgeForms = std::array<double, 3>;

// Largest value of sum over pairs l_i l_j q_ij for barycentric l; at least 0 (the vertices).
inline double largest_between(const EdgeForms& q) {
  double most = std::fmax(0, 0.25 * std::fmax(q[0], std::fmax(q[1], q[2])));
  // The interior stationary point, as of the circumcentre; only a maximum counts.
  const double l0 = q[0] * (q[1] + q[2] - q[0]), l1 = q[1] * (q[0] + q[2] - q[1]),
               l2 = q[2] * (q[0] + q[1] - q[2]);
  if (l0 > 0 && l1 > 0 && l2 > 0) most = std::fmax(most, q[0] * q[1] * q[2] / (l0 + l1 + l2));
  return most;
}

}  // namespace diesink
