// Quadratic forms of a triangle's edges, which say how far a flat triangle is from what bends.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

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

// What a form has besides at each vertex, all along the flat triangle.
using VertexValues = std::array<double, 3>;

// Largest value of sum over pairs l_i l_j q_ij + sum l_i p_i for barycentric l.
inline double largest_between(const EdgeForms& q, const VertexValues& p) {
  const double lowest = std::fmin(p[0], std::fmin(p[1], p[2]));
  const VertexValues above{p[0] - lowest, p[1] - lowest, p[2] - lowest};
  double most = std::fmax(above[0], std::fmax(above[1], above[2]));
  if (most == 0) return lowest + largest_between(q);
  EdgeForms n{};  // with l_0 + l_1 + l_2 = 1 a form of its own: these are the pairs', halved
  for (std::size_t k = 0; k < 3; ++k) {
    const double a = above[(k + 1) % 3], b = above[(k + 2) % 3];
    n[k] = 0.5 * (q[k] + a + b);
    if (q[k] > std::fabs(a - b))
      most = std::fmax(most, 0.25 * (q[k] + 2 * (a + b) + (a - b) * (a - b) / q[k]));
  }
  // Where all slopes are equal; a saddle there only names a value that the triangle has.
  const double l0 = above[1] * above[2] - n[0] * n[0] + n[1] * (n[0] - above[1]) +
                    n[2] * (n[0] - above[2]),
               l1 = above[2] * above[0] - n[1] * n[1] + n[2] * (n[1] - above[2]) +
                    n[0] * (n[1] - above[0]),
               l2 = above[0] * above[1] - n[2] * n[2] + n[0] * (n[2] - above[0]) +
                    n[1] * (n[2] - above[1]);
  const double sum = l0 + l1 + l2;
  if (l0 * sum > 0 && l1 * sum > 0 && l2 * sum > 0) {
    // The value at that place hardly minds where exactly it is; as the matrix's determinant over
    // the sum it would lose digits on slivers.
    const double a = l0 / sum, b = l1 / sum, c = l2 / sum;
    most = std::fmax(most, b * c * q[0] + c * a * q[1] + a * b * q[2] + a * above[0] +
                               b * above[1] + c * above[2]);
  }
  return lowest + most;
}

}  // namespace diesink
