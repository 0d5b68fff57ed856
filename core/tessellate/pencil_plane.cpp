// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/pencil_plane.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/compound/pencil.h"

namespace diesink {
namespace {

// The form on (r - origin) / length, its largest coefficient one.
Mat4 matrix_of(const Implicit& f, const Vec3& origin, double length) {
  const Mat3 q = f.frame.transpose() * f.k.asDiagonal() * f.frame;
  const Vec3 shift = origin - f.c, line = 0.5 * f.l * f.frame.row(2).transpose();
  Mat4 m;
  m.topLeftCorner<3, 3>() = length * length * q;
  m.topRightCorner<3, 1>() = length * (q * shift + line);
  m.bottomLeftCorner<1, 3>() = m.topRightCorner<3, 1>().transpose();
  m(3, 3) = shift.dot(q * shift) + 2 * line.dot(shift) + f.m;
  return m / m.cwiseAbs().maxCoeff();
}

}  // namespace

std::optional<Implicit> pencil_plane(const Implicit& f, const Implicit& g, const Vec3& a,
                                     const Vec3& b) {
  if (f.kind != Implicit::Kind::kQuadric || g.kind != Implicit::Kind::kQuadric) return std::nullopt;
  const Vec3 middle = 0.5 * (a + b);
  const double length = std::max({(f.c - middle).norm(), (g.c - middle).norm(), (b - a).norm()});
  if (!(length > 0)) return std::nullopt;
  const Mat4 mf = matrix_of(f, middle, length), mg = matrix_of(g, middle, length);
  // A pair of planes that holds both points holds their middle.
  if (mg(3, 3) == 0) return std::nullopt;
  double k = mf(3, 3) / mg(3, 3);
  constexpr double kPair = 1e-12;
  constexpr int kRounds = 6;
  for (int round = 0; round < kRounds && std::isfinite(k); ++round) {
    const Mat4 e = mf - k * mg;
    const Eigen::SelfAdjointEigenSolver<Mat4> solver(e);
    const Vec4& values = solver.eigenvalues();  // ascending: a pair of planes has one of each sign
    const double size = std::fmin(-values[0], values[3]);
    if (!(size > 0)) return std::nullopt;
    if (std::fmax(std::fabs(values[1]), std::fabs(values[2])) > kPair * size) {
      k += step_in_pencil(solver, mg, 1, 2);
      continue;
    }
    const Vec4 one = std::sqrt(values[3]) * solver.eigenvectors().col(3),
               two = std::sqrt(-values[0]) * solver.eigenvectors().col(0);
    std::optional<Implicit> best;
    double least = 1e-9 * length;  // of rounding, where a point is the quotient of small numbers
    for (const Vec4& plane : {Vec4(one + two), Vec4(one - two)}) {
      const double steep = plane.head<3>().norm();
      if (!(steep > 0)) continue;
      Implicit p;
      p.kind = Implicit::Kind::kPlane;
      p.c = middle;
      p.n = plane.head<3>() / steep;
      p.d = -plane[3] / steep * length;
      const double off = std::fmax(std::fabs(p.value(a)), std::fabs(p.value(b)));
      if (off > least) continue;
      least = off;
      best = p;
    }
    return best;
  }
  return std::nullopt;
}

}  // namespace diesink
