// SPDX-License-Identifier: Apache-2.0
#include "core/base/scan_fill.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <unordered_map>
#include <utility>

#include "core/base/exact_plan.h"
#include "core/base/scanned_border.h"
#include "core/mesh_tools/weld.h"
#include "core/tessellate/planar_triangulation.h"

namespace diesink {
namespace {

using Triangle = std::array<std::uint32_t, 3>;
using BorderEdge = ScannedSurface::BorderEdge;

constexpr std::uint32_t kNone = 0xFFFFFFFFU;
// A patch gets no more vertices inside; its triangles are larger where that is too few.
constexpr std::size_t kMostInside = 100'000;

double cross(const Vec3& a, const Vec3& b, const Vec3& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

double apart(const Vec3& a, const Vec3& b) { return std::hypot(a.x() - b.x(), a.y() - b.y()); }

// A closed run of border edges, the scan on its left: clockwise round a hole.
struct Loop {
  std::vector<std::uint32_t> vertices;
  double area = 0;
  PlanBox box;
};

// The border's edges as loops. Where several pass through a vertex, each goes on with the edge that
// closes the open piece of the plan on its right.
std::vector<Loop> loops_of(const std::vector<Vec3>& positions, std::vector<BorderEdge> edges) {
  std::sort(edges.begin(), edges.end());
  std::vector<char> used(edges.size(), 0);
  const auto leaving = [&](std::uint32_t v) {
    const auto from = std::lower_bound(edges.begin(), edges.end(), BorderEdge{v, 0});
    auto to = from;
    while (to != edges.end() && (*to)[0] == v) ++to;
    return std::pair{static_cast<std::size_t>(from - edges.begin()),
                     static_cast<std::size_t>(to - edges.begin())};
  };
  // How far one turns left from the way back to the way on, 0 to 2 pi.
  const auto opening = [&](std::uint32_t from, std::uint32_t at, std::uint32_t to) {
    const Vec3 &p = positions[at], &a = positions[from], &b = positions[to];
    const double angle = std::atan2(
        cross(p, a, b), (a.x() - p.x()) * (b.x() - p.x()) + (a.y() - p.y()) * (b.y() - p.y()));
    return angle > 0 ? angle : angle + 2 * std::numbers::pi;
  };
  std::vector<Loop> loops;
  for (std::size_t first = 0; first < edges.size(); ++first) {
    if (used[first]) continue;
    Loop loop;
    std::size_t edge = first;
    while (edge < edges.size()) {
      used[edge] = 1;
      loop.vertices.push_back(edges[edge][0]);
      const auto [from, at] = edges[edge];
      if (at == edges[first][0]) break;
      const auto [begin, end] = leaving(at);
      edge = edges.size();
      double least = HUGE_VAL;
      for (std::size_t k = begin; k < end; ++k) {
        if (used[k]) continue;
        const double angle = opening(from, at, edges[k][1]);
        if (angle < least) {
          least = angle;
          edge = k;
        }
      }
    }
    if (edge == edges.size() || loop.vertices.size() < 3) continue;  // no loop
    const Vec3& origin = positions[loop.vertices[0]];
    loop.box = {origin.x(), origin.x(), origin.y(), origin.y()};
    for (std::size_t k = 0; k < loop.vertices.size(); ++k) {
      const Vec3& p = positions[loop.vertices[k]];
      const Vec3& q = positions[loop.vertices[(k + 1) % loop.vertices.size()]];
      loop.area += 0.5 * cross(origin, p, q);
      loop.box = {std::min(loop.box.x0, p.x()), std::max(loop.box.x1, p.x()),
                  std::min(loop.box.y0, p.y()), std::max(loop.box.y1, p.y())};
    }
    loops.push_back(std::move(loop));
  }
  return loops;
}

// Greatest distance in plan between two vertices: between two corners of the convex hull.
double span_of(const Loop& loop, const std::vector<Vec3>& positions) {
  std::vector<std::uint32_t> order = loop.vertices;
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const Vec3 &p = positions[a], &q = positions[b];
    return p.x() != q.x() ? p.x() < q.x() : p.y() < q.y();
  });
  std::vector<std::uint32_t> hull;
  for (int side = 0; side < 2; ++side) {
    const std::size_t base = hull.size();
    for (const std::uint32_t v : order) {
      while (hull.size() >= base + 2 &&
             cross(positions[hull[hull.size() - 2]], positions[hull.back()], positions[v]) <= 0) {
        hull.pop_back();
      }
      hull.push_back(v);
    }
    std::reverse(order.begin(), order.end());
  }
  double most = 0;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      most = std::max(most, apart(positions[hull[i]], positions[hull[j]]));
    }
  }
  return most;
}

bool inside(const Loop& loop, const std::vector<Vec3>& positions, const Vec3& p) {
  bool in = false;
  for (std::size_t k = 0; k < loop.vertices.size(); ++k) {
    const Vec3& a = positions[loop.vertices[k]];
    const Vec3& b = positions[loop.vertices[(k + 1) % loop.vertices.size()]];
    if ((a.y() > p.y()) == (b.y() > p.y())) continue;
    const int side = turn(a.x(), a.y(), b.x(), b.y(), p.x(), p.y());
    if (side != 0 && (side > 0) == (b.y() > a.y())) in = !in;
  }
  return in;
}

// One patch: the vertices of its loops first, the new ones after them.
struct Patch {
  std::vector<std::uint32_t> border;  // vertices of the scan
  std::vector<Vec3> points;
  std::vector<Triangle> triangles;
};

// The region between the loops in plan, with vertices inside; false where the loops cross.
bool triangulate(const std::vector<const Loop*>& loops, const std::vector<Vec3>& positions,
                 Patch& patch) {
  std::vector<Vec2> points;
  std::vector<PlanarTriangulation::Segment> segments;
  std::unordered_map<std::uint32_t, std::uint32_t> local;
  double length = 0, area = 0;
  for (const Loop* loop : loops) {
    area -= loop->area;
    const std::size_t count = loop->vertices.size();
    for (std::size_t k = 0; k < count; ++k) {
      const std::uint32_t v = loop->vertices[k], w = loop->vertices[(k + 1) % count];
      length += apart(positions[v], positions[w]);
      const auto number = [&](std::uint32_t vertex) {
        const auto [at, fresh] =
            local.try_emplace(vertex, static_cast<std::uint32_t>(points.size()));
        if (fresh) {
          points.emplace_back(positions[vertex].x(), positions[vertex].y());
          patch.border.push_back(vertex);
          patch.points.push_back(positions[vertex]);
        }
        return at->second;
      };
      // The other way: the patch on the left.
      segments.push_back({number(w), number(v)});
    }
  }
  PlanarTriangulation plan;
  if (!plan.build(points, segments).empty()) return false;
  const double own = length / static_cast<double>(segments.size());
  // An equilateral triangle of that side, and half as large again before it is split.
  const double fewest = area / (0.87 * static_cast<double>(kMostInside));
  const double most_area = 0.65 * std::max(own * own, fewest);
  const double longest = 2.25 * std::max(own * own, fewest);
  RefineRules rules;
  rules.min_angle = 20 * std::numbers::pi / 180;
  rules.split_encroached = false;
  rules.shortest_edge = 0.4 * own;
  rules.max_vertices = points.size() + 2 * kMostInside;
  rules.too_coarse = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    const std::span<const Vec2> at = plan.points();
    const Vec2 u = at[b] - at[a], v = at[c] - at[a];
    return 0.5 * (u.x() * v.y() - u.y() * v.x()) > most_area ||
           std::max({u.squaredNorm(), v.squaredNorm(), (v - u).squaredNorm()}) > longest;
  };
  // The scan's own edges are not split.
  for (const auto& s : segments) plan.keep_segment(s[0], s[1]);
  while (true) {
    const std::vector<PlanarTriangulation::Segment> asked = plan.refine(rules);
    if (asked.empty()) break;
    for (const auto& s : asked) plan.keep_segment(s[0], s[1]);
  }
  for (std::size_t k = points.size(); k < plan.points().size(); ++k) {
    patch.points.emplace_back(plan.points()[k].x(), plan.points()[k].y(), 0);
  }
  patch.triangles = plan.triangles();
  // To the last digit: no triangle of the patch may be upright or look down.
  return std::all_of(patch.triangles.begin(), patch.triangles.end(), [&](const Triangle& t) {
    const Vec3 &a = patch.points[t[0]], &b = patch.points[t[1]], &c = patch.points[t[2]];
    return turn(a.x(), a.y(), b.x(), b.y(), c.x(), c.y()) > 0;
  });
}

// The heights inside that bend least, with the scan's triangles around counted: the sum of squares
// of the Laplacian at the patch's vertices, each over its area.
bool raise(Patch& patch, const std::vector<Vec3>& positions, std::span<const Triangle> around) {
  const std::size_t border = patch.border.size(), inner = patch.points.size() - border;
  if (inner == 0) return true;
  // Vertices beyond the border get numbers after the patch's own; lengths are taken from a point
  // near by, so that no digits are lost.
  std::vector<Vec3> points = patch.points;
  std::vector<Triangle> triangles = patch.triangles;
  std::unordered_map<std::uint32_t, std::uint32_t> local;
  for (std::size_t k = 0; k < border; ++k) {
    local.emplace(patch.border[k], static_cast<std::uint32_t>(k));
  }
  for (const Triangle& t : around) {
    Triangle own;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [at, fresh] = local.try_emplace(t[k], static_cast<std::uint32_t>(points.size()));
      if (fresh) points.push_back(positions[t[k]]);
      own[k] = at->second;
    }
    if (cross(points[own[0]], points[own[1]], points[own[2]]) < 0) std::swap(own[1], own[2]);
    triangles.push_back(own);
  }
  const Vec3 origin = points[0];
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (k < border || k >= patch.points.size()) {
      points[k] -= origin;
    } else {
      points[k] = Vec3(points[k].x() - origin.x(), points[k].y() - origin.y(), 0);
    }
  }
  using Entry = Eigen::Triplet<double>;
  const std::size_t rows = patch.points.size();
  std::vector<Entry> weights;
  std::vector<double> areas(rows, 0), angles(rows, 0);
  for (const Triangle& t : triangles) {
    const double area = 0.5 * cross(points[t[0]], points[t[1]], points[t[2]]);
    if (!(area > 0)) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t at = t[k], i = t[(k + 1) % 3], j = t[(k + 2) % 3];
      const Vec2 u = (points[i] - points[at]).head<2>(), v = (points[j] - points[at]).head<2>();
      const double cotangent = u.dot(v) / (2 * area);
      for (const auto& [p, q] : {std::pair{i, j}, std::pair{j, i}}) {
        if (p >= rows) continue;
        weights.emplace_back(static_cast<int>(p), static_cast<int>(q), 0.5 * cotangent);
        weights.emplace_back(static_cast<int>(p), static_cast<int>(p), -0.5 * cotangent);
      }
      if (at < rows) {
        areas[at] += area / 3;
        angles[at] += std::atan2(2 * area, u.dot(v));
      }
    }
  }
  // A vertex whose triangles do not lie once around it in plan tells no slope: at the outer border,
  // over walls and folds. A hundredth of a turn is far more than rounding and far less than a
  // triangle.
  Eigen::VectorXd scale(static_cast<Eigen::Index>(rows));
  for (std::size_t k = 0; k < rows; ++k) {
    const bool around_it = std::fabs(angles[k] - 2 * std::numbers::pi) < 0.06;
    scale[static_cast<Eigen::Index>(k)] = around_it ? 1 / std::sqrt(areas[k]) : 0;
  }
  Eigen::SparseMatrix<double> laplacian(static_cast<Eigen::Index>(rows),
                                        static_cast<Eigen::Index>(points.size()));
  laplacian.setFromTriplets(weights.begin(), weights.end());
  laplacian = scale.asDiagonal() * laplacian;
  const auto first = static_cast<Eigen::Index>(border), count = static_cast<Eigen::Index>(inner);
  Eigen::VectorXd known(static_cast<Eigen::Index>(points.size()));
  for (std::size_t k = 0; k < points.size(); ++k) {
    known[static_cast<Eigen::Index>(k)] = points[k].z();  // 0 inside
  }
  const Eigen::SparseMatrix<double> free = laplacian.middleCols(first, count);
  const Eigen::VectorXd given = free.transpose() * (laplacian * known);
  const Eigen::SparseMatrix<double> bending = free.transpose() * free;
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(bending);
  if (solver.info() != Eigen::Success) return false;
  const Eigen::VectorXd z = solver.solve(-given);
  if (!z.allFinite()) return false;
  for (std::size_t k = 0; k < inner; ++k) {
    patch.points[border + k].z() = origin.z() + z[static_cast<Eigen::Index>(k)];
  }
  return true;
}

}  // namespace

ScanFill fill_holes(std::vector<Vec3>& positions, std::vector<Triangle>& triangles, double size) {
  ScanFill fill;
  // Equal positions count as one vertex, whatever the file says: the first of them.
  std::vector<Triangle> welded(triangles.size());
  {
    const WeldMap map = weld_map(positions);
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      for (std::size_t k = 0; k < 3; ++k) welded[t][k] = map.kept[map.of_vertex[triangles[t][k]]];
    }
  }
  const std::vector<Loop> loops = loops_of(positions, plan_border(positions, welded));
  // Holes small enough, and islands, which belong to the smallest hole around them.
  std::vector<std::size_t> holes, islands;
  for (std::size_t k = 0; k < loops.size(); ++k) {
    const PlanBox& b = loops[k].box;
    if (std::max(b.x1 - b.x0, b.y1 - b.y0) > size) continue;
    if (loops[k].area > 0) {
      islands.push_back(k);
    } else if (loops[k].area < 0 && span_of(loops[k], positions) <= size) {
      holes.push_back(k);
    }
  }
  std::sort(islands.begin(), islands.end(), [&](std::size_t a, std::size_t b) {
    return std::pair(loops[a].box.x0, a) < std::pair(loops[b].box.x0, b);
  });
  std::vector<std::size_t> hole_of(loops.size(), loops.size());
  for (const std::size_t h : holes) {
    const PlanBox& box = loops[h].box;
    for (auto i = std::lower_bound(islands.begin(), islands.end(), box.x0,
                                   [&](std::size_t k, double x) { return loops[k].box.x0 < x; });
         i != islands.end() && loops[*i].box.x0 <= box.x1; ++i) {
      const PlanBox& b = loops[*i].box;
      if (b.x1 > box.x1 || b.y0 < box.y0 || b.y1 > box.y1) continue;
      std::size_t& mine = hole_of[*i];
      if (mine < loops.size() && loops[mine].area >= loops[h].area) continue;
      if (inside(loops[h], positions, positions[loops[*i].vertices[0]])) mine = h;
    }
  }
  std::vector<std::vector<const Loop*>> regions;
  std::vector<std::size_t> region_of(loops.size(), loops.size());
  for (const std::size_t h : holes) {
    region_of[h] = regions.size();
    regions.push_back({&loops[h]});
  }
  for (const std::size_t i : islands) {
    if (hole_of[i] < loops.size()) regions[region_of[hole_of[i]]].push_back(&loops[i]);
  }
  // The scan's triangles around each: those with a vertex on its loops.
  std::unordered_multimap<std::uint32_t, std::uint32_t> regions_at;
  for (std::uint32_t r = 0; r < regions.size(); ++r) {
    for (const Loop* loop : regions[r]) {
      for (const std::uint32_t v : loop->vertices) regions_at.emplace(v, r);
    }
  }
  std::vector<std::vector<Triangle>> around(regions.size());
  std::vector<char> on_loop(positions.size(), 0);
  for (const auto& [vertex, region] : regions_at) on_loop[vertex] = 1;
  for (const Triangle& t : welded) {
    std::vector<std::uint32_t> taken;
    for (const std::uint32_t v : t) {
      if (!on_loop[v]) continue;
      const auto [begin, end] = regions_at.equal_range(v);
      for (auto at = begin; at != end; ++at) {
        if (std::find(taken.begin(), taken.end(), at->second) != taken.end()) continue;
        taken.push_back(at->second);
        around[at->second].push_back(t);
      }
    }
  }
  for (std::size_t r = 0; r < regions.size(); ++r) {
    Patch patch;
    if (!triangulate(regions[r], positions, patch) || !raise(patch, positions, around[r])) continue;
    ++fill.holes;
    fill.triangles += patch.triangles.size();
    const auto first = static_cast<std::uint32_t>(positions.size());
    const auto border = static_cast<std::uint32_t>(patch.border.size());
    positions.insert(positions.end(), patch.points.begin() + border, patch.points.end());
    for (const Triangle& t : patch.triangles) {
      fill.area += 0.5 * cross(patch.points[t[0]], patch.points[t[1]], patch.points[t[2]]);
      Triangle placed;
      for (std::size_t k = 0; k < 3; ++k) {
        placed[k] = t[k] < border ? patch.border[t[k]] : first + (t[k] - border);
      }
      triangles.push_back(placed);
    }
  }
  return fill;
}

}  // namespace diesink
