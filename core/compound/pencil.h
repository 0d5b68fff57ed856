// The pencil F - k G of two quadrics: its degenerate members are what two quadrics that touch, or
// meet in plane curves, have in common.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Eigenvalues>

namespace diesink {

// Forms on (x, y, z, 1).
using Mat4 = Eigen::Matrix4d;
using Vec4 = Eigen::Vector4d;

// A step of Newton's method from k towards the member of the pencil whose eigenvalues `first` ..
// `last` (in the solver's order, of F - k G) are nothing all together: in the sense of least
// squares, as they change with k by -v'Gv. Not finite where G says nothing of them.
// Source: perturbation of a symmetric matrix's eigenvalues.
inline double step_in_pencil(const Eigen::SelfAdjointEigenSolver<Mat4>& member, const Mat4& g,
                             int first, int last) {
  double up = 0, down = 0;
  for (int i = first; i <= last; ++i) {
    const Vec4 v = member.eigenvectors().col(i);
    const double turn = v.dot(g * v);
    up += member.eigenvalues()[i] * turn;
    down += turn * turn;
  }
  return up / down;
}

}  // namespace diesink
