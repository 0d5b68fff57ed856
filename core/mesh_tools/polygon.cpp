// SPDX-License-Identifier: Apache-2.0
#include "core/mesh_tools/polygon.h"

#include <cmath>

namespace diesink {
namespace {

double turn(const Vec2& a, const Vec2& b, const Vec2& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

// The corners in the coordinate plane their Newell normal is most upright on, anticlockwise.
std::vector<Vec2> flatten(std::span<const Vec3> corners) {
  Vec3 normal = Vec3::Zero();
  const Vec3 origin = corners[0];
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3 a = corners[i] - origin, b = corners[(i + 1) % corners.size()] - origin;
    normal += Vec3((a.y() - b.y()) * (a.z() + b.z()), (a.z() - b.z()) * (a.x() + b.x()),
                   (a.x() - b.x()) * (a.y() + b.y()));
  }
  int up = 0;
  normal.cwiseAbs().maxCoeff(&up);
  int u = (up + 1) % 3, v = (up + 2) % 3;
  if (normal[up] < 0) std::swap(u, v);
  std::vector<Vec2> plan;
  plan.reserve(corners.size());
  for (const Vec3& p : corners) plan.emplace_back(p[u] - origin[u], p[v] - origin[v]);
  return plan;
}

// Every turn to the left and once around in all: x changes its direction just twice.
bool is_convex(const std::vector<Vec2>& plan) {
  const std::size_t n = plan.size();
  int reversals = 0;
  double last_step = 0;
  for (std::size_t i = n; i-- > 0 && last_step == 0;)
    last_step = plan[(i + 1) % n].x() - plan[i].x();
  for (std::size_t i = 0; i < n; ++i) {
    if (turn(plan[i], plan[(i + 1) % n], plan[(i + 2) % n]) < 0) return false;
    const double step = plan[(i + 1) % n].x() - plan[i].x();
    if (step == 0) continue;
    if ((step > 0) != (last_step > 0)) ++reversals;
    last_step = step;
  }
  return reversals <= 2;
}

bool contains(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& p) {
  return turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0;
}

}  // namespace

bool cut_polygon(std::span<const Vec3> corners,
                 std::vector<std::array<std::uint32_t, 3>>& triangles) {
  const auto fan = [&] {
    for (std::uint32_t i = 1; i + 1 < corners.size(); ++i) triangles.push_back({0, i, i + 1});
  };
  if (corners.size() == 3) {
    fan();
    return true;
  }
  const std::vector<Vec2> plan = flatten(corners);
  if (is_convex(plan)) {
    fan();
    return true;
  }
  if (corners.size() > kMaxConcaveCorners) {
    fan();
    return false;
  }
  std::vector<std::uint32_t> ring(corners.size());
  for (std::uint32_t i = 0; i < ring.size(); ++i) ring[i] = i;
  bool clean = true;
  std::size_t at = 0, refused = 0;
  while (ring.size() > 3) {
    const std::size_t n = ring.size();
    at %= n;
    const std::size_t before = (at + n - 1) % n, after = (at + 1) % n;
    const Vec2 &a = plan[ring[before]], &b = plan[ring[at]], &c = plan[ring[after]];
    bool ear = turn(a, b, c) > 0;
    for (std::size_t i = 0; ear && i < n; ++i) {
      if (i == before || i == at || i == after) continue;
      const Vec2& p = plan[ring[i]];
      // A corner that touches the ear (a hole's bridge) is no obstacle.
      if (p != a && p != b && p != c && contains(a, b, c, p)) ear = false;
    }
    // After a whole round without an ear whatever is next is cut: the polygon crosses itself or is
    // a line.
    if (!ear && refused < n) {
      ++refused;
      ++at;
      continue;
    }
    if (!ear) clean = false;
    triangles.push_back({ring[before], ring[at], ring[after]});
    ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(at));
    refused = 0;
    // One back: ears beside each other would make slivers that all meet in one corner.
    at = before < at ? before : 0;
  }
  triangles.push_back({ring[0], ring[1], ring[2]});
  return clean && turn(plan[ring[0]], plan[ring[1]], plan[ring[2]]) >= 0;
}

}  // namespace diesink
