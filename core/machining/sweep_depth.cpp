// SPDX-License-Identifier: Apache-2.0
#include "core/machining/sweep_depth.h"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

namespace diesink {
namespace {

// An upright column of radius `radius` from `low` over the tip to the ceiling, swept along the
// move.
struct Core {
  SweepMove move;
  double radius = 0, low = 0, ceiling = 0;

  [[nodiscard]] Vec3 support(const Vec3& d) const {
    const Vec3& end = move.to.dot(d) > move.from.dot(d) ? move.to : move.from;
    // Up, the column's top is the same over the whole move.
    Vec3 p = end;
    if (d.z() > 0) {
      p = (move.to - move.from).head<2>().dot(d.head<2>()) > 0 ? move.to : move.from;
      p.z() = ceiling;
    } else {
      p.z() += low;
    }
    if (radius > 0) {
      const double flat = d.head<2>().norm();
      if (flat > 0) p.head<2>() += radius / flat * d.head<2>();
    }
    return p;
  }
};

struct Distance {
  double low = 0, high = std::numeric_limits<double>::infinity();
};

// The simplex of the iteration: differences of support points.
struct Simplex {
  std::array<Vec3, 4> p;
  int size = 0;
};

// Coefficients of the point nearest to the origin on the affine hull of the chosen points; false
// where they are not all positive or the points are dependent.
bool nearest_of(const std::array<const Vec3*, 4>& p, int n, Vec3& nearest) {
  const Vec3& a = *p[0];
  if (n == 1) {
    nearest = a;
    return true;
  }
  const Vec3 e1 = *p[1] - a;
  if (n == 2) {
    const double length = e1.squaredNorm();
    if (!(length > 0)) return false;
    const double t = -a.dot(e1) / length;
    if (!(t >= 0 && t <= 1)) return false;
    nearest = a + t * e1;
    return true;
  }
  const Vec3 e2 = *p[2] - a;
  if (n == 3) {
    const Vec3 normal = e1.cross(e2);
    const double area = normal.squaredNorm();
    if (!(area > 1e-28 * e1.squaredNorm() * e2.squaredNorm())) return false;
    const Vec3 foot = normal * (a.dot(normal) / area);
    const Vec3 o = foot - a;
    const double s = o.cross(e2).dot(normal) / area, t = e1.cross(o).dot(normal) / area;
    if (!(s >= 0 && t >= 0 && s + t <= 1)) return false;
    nearest = foot;
    return true;
  }
  const Vec3 e3 = *p[3] - a;
  const double volume = e1.dot(e2.cross(e3));
  if (!(std::fabs(volume) > 1e-14 * e1.norm() * e2.norm() * e3.norm())) return false;
  const Vec3 o = -a;
  const double s = o.dot(e2.cross(e3)) / volume, t = e1.dot(o.cross(e3)) / volume,
               u = e1.dot(e2.cross(o)) / volume;
  if (!(s >= 0 && t >= 0 && u >= 0 && s + t + u <= 1)) return false;
  nearest = Vec3::Zero();
  return true;
}

// Reduces the simplex to the part whose nearest point to the origin it is. The newest point is the
// last.
Vec3 reduce(Simplex& simplex) {
  const int n = simplex.size;
  const int newest = n - 1;
  double best = std::numeric_limits<double>::infinity();
  Vec3 nearest = simplex.p[static_cast<std::size_t>(newest)];
  unsigned best_set = 1u << newest;
  for (unsigned set = 0; set < (1u << newest); ++set) {
    std::array<const Vec3*, 4> chosen{&simplex.p[static_cast<std::size_t>(newest)], nullptr,
                                      nullptr, nullptr};
    int count = 1;
    for (int k = 0; k < newest; ++k) {
      if (set >> k & 1u)
        chosen[static_cast<std::size_t>(count++)] = &simplex.p[static_cast<std::size_t>(k)];
    }
    Vec3 point;
    if (!nearest_of(chosen, count, point)) continue;
    const double distance = point.squaredNorm();
    if (distance < best) {
      best = distance;
      nearest = point;
      best_set = set | 1u << newest;
    }
  }
  Simplex kept;
  for (int k = 0; k < n; ++k) {
    if (best_set >> k & 1u)
      kept.p[static_cast<std::size_t>(kept.size++)] = simplex.p[static_cast<std::size_t>(k)];
  }
  simplex = kept;
  return nearest;
}

// Bounds of the distance between the core and the triangle; stops early once it is certainly beyond
// `enough` or certainly known to `precision`.
Distance distance_of(const Core& core, const std::array<Vec3, 3>& triangle, double enough,
                     double precision) {
  const auto support = [&](const Vec3& d) -> Vec3 {
    // Farthest of triangle minus core along d.
    const double a = triangle[0].dot(d), b = triangle[1].dot(d), c = triangle[2].dot(d);
    const Vec3& t = a >= b && a >= c ? triangle[0] : b >= c ? triangle[1] : triangle[2];
    return t - core.support(-d);
  };
  const Vec3 middle = (core.move.from + core.move.to) / 2;
  Vec3 v = (triangle[0] + triangle[1] + triangle[2]) / 3 - middle - Vec3(0, 0, core.low);
  Distance out;
  Simplex simplex;
  double scale = v.norm() + precision;
  for (int step = 0; step < 60; ++step) {
    const double size = v.norm();
    if (!(size > 1e-14 * scale)) return {0, 0};
    const Vec3 w = support(-v);
    // v is a point of the difference from the second step on, so its length bounds from above.
    if (step > 0) out.high = std::fmin(out.high, size);
    out.low = std::fmax(out.low, v.dot(w) / size);
    if (out.low > enough || out.high - out.low <= precision) break;
    bool known = false;
    for (int k = 0; k < simplex.size; ++k)
      known = known || simplex.p[static_cast<std::size_t>(k)] == w;
    if (known) break;
    simplex.p[static_cast<std::size_t>(simplex.size++)] = w;
    scale = std::fmax(scale, w.norm());
    v = reduce(simplex);
    if (simplex.size == 4) return {0, 0};
  }
  return out;
}

Core core_of(const CutterShape& cutter, const SweepMove& move, double ceiling, double shrunk) {
  // Shrunk by no more than the corner the column stays, and the rest of the corner goes round it.
  const double more = std::fmax(0, shrunk - cutter.corner());
  return {move, std::fmax(0, cutter.flat() - more), cutter.corner() + more, ceiling};
}

}  // namespace

SweepDepth sweep_depth(const CutterShape& cutter, const SweepMove& move,
                       const std::array<Vec3, 3>& triangle, double floor, double ceiling) {
  const double r = cutter.corner(), precision = 1e-9 * cutter.radius();
  if (floor < r) {
    const Distance d =
        distance_of(core_of(cutter, move, ceiling, 0), triangle, r - floor, precision / 2);
    if (d.low >= r - floor) return {};
    if (d.high > 0) return {std::fmax(0, r - d.high), r - d.low};
    if (!(cutter.flat() > 0)) return {r, r};  // the axis itself: no point lies deeper
  }
  // Deeper than the corner: halve the depth at which the shrunk column is met.
  const auto met = [&](double m) {
    return distance_of(core_of(cutter, move, ceiling, m), triangle, 0, precision / 2).low <= 0;
  };
  double low = std::fmax(floor, r), high = cutter.radius();
  if (!met(low)) return floor < r ? SweepDepth{r, r} : SweepDepth{};
  while (high - low > precision) {
    const double middle = low + (high - low) / 2;
    (met(middle) ? low : high) = middle;
  }
  return {low, high};
}

}  // namespace diesink
