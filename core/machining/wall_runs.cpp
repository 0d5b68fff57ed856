// SPDX-License-Identifier: Apache-2.0
#include "core/machining/wall_runs.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/machining/path_fit.h"

namespace diesink {
namespace {

// An edge at the top of a wall, or where the surface ends, the surface to its left and the wall
// falling away to its right.
struct TopEdge {
  std::uint32_t from = 0, to = 0;
};

std::vector<TopEdge> top_edges(const TriangleMesh& mesh) {
  // Edges of upright triangles that lie above the triangle's third corner, and those of one
  // triangle alone.
  std::vector<std::array<std::uint32_t, 2>> tops;
  std::vector<std::uint32_t> level;
  const auto& points = mesh.positions;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& v = mesh.triangles[t];
    const Vec3 n = (points[v[1]] - points[v[0]]).cross(points[v[2]] - points[v[0]]);
    const double size = n.norm();
    if (faces_up(n, size)) {
      level.push_back(static_cast<std::uint32_t>(t));
      continue;
    }
    if (!(size > 0)) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = v[k], b = v[(k + 1) % 3];
      const Vec3 d = points[b] - points[a], o = points[v[(k + 2) % 3]] - points[a];
      const double length2 = d.head<2>().squaredNorm();
      if (!(length2 > 0)) continue;
      const double along = o.head<2>().dot(d.head<2>()) / length2;
      if (o.z() < along * d.z()) tops.push_back({std::min(a, b), std::max(a, b)});
    }
  }
  std::vector<std::array<std::uint32_t, 2>> all;
  all.reserve(3 * mesh.triangles.size());
  for (const auto& v : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      all.push_back({std::min(v[k], v[(k + 1) % 3]), std::max(v[k], v[(k + 1) % 3])});
    }
  }
  std::sort(all.begin(), all.end());
  for (std::size_t k = 0; k < all.size(); ++k) {
    const bool alone =
        (k == 0 || all[k - 1] != all[k]) && (k + 1 == all.size() || all[k + 1] != all[k]);
    if (alone) tops.push_back(all[k]);
  }
  std::sort(tops.begin(), tops.end());
  std::vector<TopEdge> edges;
  if (tops.empty()) return edges;
  for (const std::uint32_t t : level) {
    const auto& v = mesh.triangles[t];
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = v[k], b = v[(k + 1) % 3];
      if (std::binary_search(tops.begin(), tops.end(),
                             std::array<std::uint32_t, 2>{std::min(a, b), std::max(a, b)})) {
        edges.push_back({a, b});
      }
    }
  }
  return edges;
}

// Edges in the order of the walls: each chain from its beginning, closed ones from anywhere.
std::vector<std::vector<TopEdge>> chains(const std::vector<TopEdge>& edges) {
  std::vector<std::uint32_t> by_start(edges.size());
  for (std::size_t k = 0; k < edges.size(); ++k) by_start[k] = static_cast<std::uint32_t>(k);
  const auto start = [&](std::uint32_t k) { return edges[k].from; };
  std::sort(by_start.begin(), by_start.end(), [&](std::uint32_t p, std::uint32_t q) {
    return start(p) != start(q) ? start(p) < start(q) : p < q;
  });
  std::vector<std::uint32_t> ends;
  for (const TopEdge& e : edges) ends.push_back(e.to);
  std::sort(ends.begin(), ends.end());
  std::vector<std::uint8_t> used(edges.size(), 0);
  std::vector<std::vector<TopEdge>> out;
  const auto follow = [&](std::uint32_t first) {
    out.emplace_back();
    for (std::uint32_t k = first;;) {
      used[k] = 1;
      out.back().push_back(edges[k]);
      auto next = std::lower_bound(by_start.begin(), by_start.end(), edges[k].to,
                                   [&](std::uint32_t p, std::uint32_t v) { return start(p) < v; });
      while (next != by_start.end() && start(*next) == edges[k].to && used[*next]) ++next;
      if (next == by_start.end() || start(*next) != edges[k].to) return;
      k = *next;
    }
  };
  for (std::uint32_t k = 0; k < edges.size(); ++k) {
    if (!used[k] && !std::binary_search(ends.begin(), ends.end(), edges[k].from)) follow(k);
  }
  for (std::uint32_t k = 0; k < edges.size(); ++k) {
    if (!used[k]) follow(k);
  }
  return out;
}

class WallFollower {
 public:
  WallFollower(const TriangleMesh& mesh, const OffsetSurface& offset, const PointDrop& drop,
               const WallRunOptions& options)
      : mesh_(mesh),
        offset_(offset),
        options_(options),
        profile_(offset, drop, options.chord),
        radius_(offset.cutter().radius() * (1 + 1e-7)),
        near_(options.above / 4 + 1e-6 * radius_) {}

  void follow(const std::vector<TopEdge>& chain) {
    for (std::size_t k = 0; k < chain.size(); ++k) {
      const Vec3 a = point(chain[k].from), b = point(chain[k].to);
      const Vec2 d = (b - a).head<2>();
      const double length = d.norm();
      if (!(length > 0)) continue;
      const Vec2 out(d.y() / length, -d.x() / length);
      along(a.head<2>() + radius_ * out, b.head<2>() + radius_ * out, a.z(), b.z());
      const bool closed = chain.back().to == chain.front().from;
      if (k + 1 == chain.size() && !closed) break;
      const TopEdge& next = chain[(k + 1) % chain.size()];
      const Vec2 e = (point(next.to) - point(next.from)).head<2>();
      if (!(e.norm() > 0)) continue;
      around(b, out, Vec2(e.y(), -e.x()) / e.norm());
    }
    close();
  }
  std::vector<std::vector<Vec3>> take() { return std::move(runs_); }

 private:
  [[nodiscard]] Vec3 point(std::uint32_t v) const { return offset_.to_frame(mesh_.positions[v]); }

  // About a corner, on a polygon round the circle, so that no side comes nearer to the corner.
  void around(const Vec3& corner, const Vec2& from, const Vec2& to) {
    const double angle = std::atan2(from.x() * to.y() - from.y() * to.x(), from.dot(to));
    if (angle <= 0) return;  // an inner corner: the sides end each other
    const double most = std::acos(1 / (1 + options_.above / (2 * radius_)));
    const double count = std::max(1.0, std::ceil(angle / (2 * most)));
    const double half = angle / (2 * count);
    Vec2 last = corner.head<2>() + radius_ * from;
    for (double k = 0; k <= count; ++k) {
      const double turn = std::min((2 * k + 1) * half, angle);
      const double reach = k < count ? radius_ / std::cos(half) : radius_;
      const double c = std::cos(turn), s = std::sin(turn);
      const Vec2 next =
          corner.head<2>() + reach * Vec2(from.x() * c - from.y() * s, from.x() * s + from.y() * c);
      along(last, next, corner.z(), corner.z());
      last = next;
    }
  }

  void along(Vec2 a, Vec2 b, double top_a, double top_b) {
    double t0 = 0, t1 = 1;
    for (std::size_t k = 0; k < 4; ++k) {
      const Vec2 &p = options_.domain[k], q = options_.domain[(k + 1) % 4];
      const Vec2 n(p.y() - q.y(), q.x() - p.x());  // inward
      const double at = n.dot(a - p), change = n.dot(b - a);
      if (change > 0) {
        t0 = std::max(t0, -at / change);
      } else if (change < 0) {
        t1 = std::min(t1, -at / change);
      } else if (at < 0) {
        return;
      }
    }
    if (!(t0 < t1)) return;
    const double slope = top_b - top_a;
    top_b = top_a + t1 * slope;
    top_a = top_a + t0 * slope;
    const Vec2 d = b - a;
    b = a + t1 * d;
    a = a + t0 * d;
    const PlanLine line(a, b);
    if (!(line.length > 0)) return;
    // Only where the cutter stands beside the wall and not on something.
    low_.clear();
    for (ProfileSegment s : profile_.take(a, b, kNoContact)) {
      const auto deeper = [&](double x, double z) {
        return top_a + x / line.length * (top_b - top_a) - offset_.cutter().corner() - z -
               options_.least_depth;
      };
      const double at0 = deeper(s.x0, s.z0), at1 = deeper(s.x1, s.z1);
      if (!(at0 > 0) && !(at1 > 0)) continue;
      if (!(at0 > 0) || !(at1 > 0)) {  // from where it is deep enough, or up to there
        const double t = at0 / (at0 - at1);
        const double x = s.x0 + t * (s.x1 - s.x0), z = s.z0 + t * (s.z1 - s.z0);
        (at0 > 0 ? s.x1 : s.x0) = x;
        (at0 > 0 ? s.z1 : s.z0) = z;
      }
      low_.push_back(s);
    }
    for (const PassRun& run : fit_runs(low_, options_.below, options_.above, 1e-7 * radius_)) {
      for (const Vec2& p : run) {
        const Vec2 at = line.at(p.x());
        add(Vec3(at.x(), at.y(), p.y()), &p == &run.front());
      }
    }
  }

  void add(const Vec3& tip, bool begins) {
    if (begins && !run_.empty() && (tip - run_.back()).norm() > near_) close();
    if (run_.empty() || run_.back() != tip) run_.push_back(tip);
  }
  void close() {
    if (run_.size() > 1) runs_.push_back(std::move(run_));
    run_.clear();
  }

  const TriangleMesh& mesh_;
  const OffsetSurface& offset_;
  const WallRunOptions& options_;
  SegmentProfile profile_;
  double radius_, near_;
  std::vector<ProfileSegment> low_;
  std::vector<Vec3> run_;
  std::vector<std::vector<Vec3>> runs_;
};

}  // namespace

std::vector<std::vector<Vec3>> wall_runs(const TriangleMesh& mesh, const OffsetSurface& offset,
                                         const PointDrop& drop, const WallRunOptions& options) {
  WallFollower follower(mesh, offset, drop, options);
  for (const std::vector<TopEdge>& chain : chains(top_edges(mesh))) follower.follow(chain);
  return follower.take();
}

}  // namespace diesink
