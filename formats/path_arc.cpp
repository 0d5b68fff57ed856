// SPDX-License-Identifier: Apache-2.0
#include "formats/path_arc.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace diesink {
namespace {

constexpr double kWhole = 2 * std::numbers::pi;

double of_millimetres(double mm, LengthUnit unit) { return mm / 1000 / metres_per(unit); }

Vec3 square_to(const Vec3& axis, const Vec3& d) { return d - axis.dot(d) * axis; }

}  // namespace

double turn_between(const Vec3& center, const Vec3& axis, const Vec3& from, const Vec3& to) {
  const Vec3 a = square_to(axis, from - center), b = square_to(axis, to - center);
  const double turn = std::atan2(axis.dot(a.cross(b)), a.dot(b));
  return turn > 0 ? turn : turn + kWhole;
}

double radius_about(const Vec3& center, const Vec3& axis, const Vec3& p) {
  return square_to(axis, p - center).norm();
}

bool same_radius(double a, double b, LengthUnit unit) {
  return std::fabs(a - b) <= std::max(of_millimetres(0.01, unit), 1e-3 * std::max(a, b));
}

double add_arc(PointsRead& points, const Vec3& to, const PathArc& arc, Motion motion,
               LengthUnit unit) {
  const Vec3 from = points.last();
  const Vec3 a = square_to(arc.axis, from - arc.center);
  const double r0 = a.norm(), r1 = radius_about(arc.center, arc.axis, to);
  const double height = std::max(of_millimetres(1e-4, unit), 1e-9 * std::max(r0, r1));
  // No more than a quarter turn at once, so that small circles are not lost.
  const double step =
      std::min(2 * std::acos(std::max(0.0, 1 - height / std::max(r0, r1))), kWhole / 4);
  const double count = std::max(1.0, std::ceil(arc.turn / step));
  const Vec3 e = a / r0, f = arc.axis.cross(e);
  const double h0 = arc.axis.dot(from - arc.center), h1 = arc.axis.dot(to - arc.center);
  for (double k = 1; k < count; ++k) {
    const double part = k / count, angle = part * arc.turn, r = r0 + part * (r1 - r0);
    points.add(arc.center + r * (std::cos(angle) * e + std::sin(angle) * f) +
                   (h0 + part * (h1 - h0)) * arc.axis,
               motion);
  }
  points.add(to, motion);
  return height + std::fabs(r1 - r0);
}

}  // namespace diesink
