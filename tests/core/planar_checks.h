// What every triangulation of a region must satisfy, checked the slow and plain way.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <random>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "core/tessellate/planar_triangulation.h"

namespace diesink {

using Segment = PlanarTriangulation::Segment;
using Corners = PlanarTriangulation::Corners;

struct Region {
  std::vector<Vec2> points;
  std::vector<Segment> segments;

  // A closed loop; anticlockwise ones hold the region.
  void add_loop(std::span<const Vec2> loop) {
    const auto first = static_cast<std::uint32_t>(points.size());
    const auto count = static_cast<std::uint32_t>(loop.size());
    points.insert(points.end(), loop.begin(), loop.end());
    for (std::uint32_t i = 0; i < count; ++i) {
      segments.push_back({first + i, first + (i + 1) % count});
    }
  }
};

inline std::vector<Vec2> circle(const Vec2& centre, double radius, int count,
                                bool clockwise = false, double turn = 0) {
  std::vector<Vec2> loop;
  for (int i = 0; i < count; ++i) {
    const double angle = turn + 2 * std::numbers::pi * (clockwise ? -i : i) / count;
    loop.push_back(centre + radius * Vec2(std::cos(angle), std::sin(angle)));
  }
  return loop;
}

inline long double twice_area(const Vec2& a, const Vec2& b, const Vec2& c) {
  using L = long double;
  return (L(b.x()) - L(a.x())) * (L(c.y()) - L(a.y())) -
         (L(b.y()) - L(a.y())) * (L(c.x()) - L(a.x()));
}

// Twice the area on the left of the segments.
inline long double twice_area(std::span<const Vec2> points, std::span<const Segment> segments) {
  long double sum = 0;
  for (const Segment& s : segments) sum += twice_area(points[0], points[s[0]], points[s[1]]);
  return sum;
}

// How far d lies inside the circle through a, b, c, as the usual determinant.
inline long double in_circle_value(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  using L = long double;
  const L ax = L(a.x()) - L(d.x()), ay = L(a.y()) - L(d.y());
  const L bx = L(b.x()) - L(d.x()), by = L(b.y()) - L(d.y());
  const L cx = L(c.x()) - L(d.x()), cy = L(c.y()) - L(d.y());
  return (ax * ax + ay * ay) * (bx * cy - cx * by) + (bx * bx + by * by) * (cx * ay - ax * cy) +
         (cx * cx + cy * cy) * (ax * by - bx * ay);
}

inline double smallest_angle(const Vec2& a, const Vec2& b, const Vec2& c) {
  const auto at = [](const Vec2& p, const Vec2& q, const Vec2& r) {
    const Vec2 u = q - p, v = r - p;
    return std::atan2(std::abs(u.x() * v.y() - u.y() * v.x()), u.dot(v));
  };
  return std::min({at(a, b, c), at(b, c, a), at(c, a, b)});
}

// Triangles anticlockwise and edge to edge; the border is exactly the given segments; the area is
// what the segments enclose; every edge that is no segment has empty circles beside it.
inline void check_region(std::span<const Vec2> points, std::span<const Segment> segments,
                         std::span<const Corners> triangles, double size = 1) {
  const std::set<Segment> border(segments.begin(), segments.end());
  std::map<Segment, std::uint32_t> apexes;
  long double sum = 0;
  for (const Corners& t : triangles) {
    const long double area = twice_area(points[t[0]], points[t[1]], points[t[2]]);
    ASSERT_GE(area, 0.0L);
    sum += area;
    for (std::size_t e = 0; e < 3; ++e) {
      const Segment edge{t[e], t[(e + 1) % 3]};
      ASSERT_TRUE(apexes.emplace(edge, t[(e + 2) % 3]).second) << "an edge with two triangles";
    }
  }
  ASSERT_NEAR(static_cast<double>(sum), static_cast<double>(twice_area(points, segments)),
              1e-11 * size * size);
  for (const Segment& s : border) ASSERT_TRUE(apexes.count(s) == 1) << s[0] << ' ' << s[1];
  for (const auto& [edge, apex] : apexes) {
    if (border.count(edge) != 0) continue;
    const auto other = apexes.find({edge[1], edge[0]});
    ASSERT_TRUE(other != apexes.end()) << "a border that is no segment";
    if (border.count({edge[1], edge[0]}) != 0) continue;
    ASSERT_LE(
        in_circle_value(points[edge[0]], points[edge[1]], points[apex], points[other->second]),
        1e-12L * size * size * size * size);
  }
}

}  // namespace diesink
