// SPDX-License-Identifier: Apache-2.0
#include "core/machining/path_interval.h"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

namespace diesink {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Half the angle between the normals of the two contacts, seen from the centre of curvature:
// (15) is 2 |rho| sin of it, from the triangle with sides R + rho, h + rho and R.
// Returned as sin(half)·|rho| with its limit for a plane; negative where there is no triangle.
double half_chord(double R, double curvature, double h) {
  // The root of (15) is sixteen times the squared area of that triangle, so by Heron's formula it
  // is h (2R - h) (2 rho + h) (2 rho + h + 2R): with k = 1/rho it stays well conditioned through k
  // = 0.
  const double k = curvature;
  const double product = h * (2 * R - h) * (2 + h * k) * (2 + (h + 2 * R) * k);
  const double below = 2 * (1 + R * k) * (1 + h * k);
  if (!(product > 0) || !(below > 0)) return -1;
  return std::sqrt(product) / below;
}

}  // namespace

double cusp_interval(double R, double curvature, double h) {
  if (h >= 2 * R) return kInfinity;
  const double half = half_chord(R, curvature, h);
  return half < 0 ? kInfinity : 2 * half;
}

Vec3 across_of(const Vec3& normal, const Vec2& along) {
  const Vec3 t_p(along.x(), along.y(), 0);
  const Vec3 t = normal.cross(t_p.cross(Vec3::UnitZ())).normalized();
  return normal.cross(t).normalized();
}

double plan_interval(double on_surface, const Vec3& normal, const Vec2& along) {
  return on_surface * across_of(normal, along).head<2>().norm();
}

double drop_interval(const CutterShape& cutter, const Vec3& normal, const Vec2& along,
                     double curvature, double h) {
  const Vec3 e = across_of(normal, along);
  const double square = std::fabs(e.y() * along.x() - e.x() * along.y());
  const double r = cutter.corner();
  double interval = 0;
  if (r > 0) {
    const double corner = cusp_interval(r, curvature, std::fmin(h, r));
    // A bowl narrower than the corner leaves no cusp.
    interval = std::isinf(corner) ? corner : corner * (1 + r * curvature) * square;
  }
  if (cutter.flat() > 0) {
    // Level ground: the flat's own width more. On a slope the sharp corner's triangle, of the
    // height l sin cos; the round corner stays within (sqrt 2 - 1) r of the sharp one.
    const double lean = std::fabs(e.z());
    const double usable = h - 0.41421356237309515 * r;
    const double level = 2 * cutter.flat() + interval;
    if (lean < 1e-9) {
      interval = level;
    } else if (usable > 0) {
      interval = std::fmax(interval, std::fmin(level, usable / lean));
    }
  }
  return std::fmin(interval, 2 * cutter.radius());
}

}  // namespace diesink
