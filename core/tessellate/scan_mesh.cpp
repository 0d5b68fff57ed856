// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/scan_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <unordered_set>

#include "core/mesh_tools/topology.h"
#include "core/parallel.h"

namespace diesink {
namespace {

using Impl = CompoundSurface::Impl;
constexpr std::uint32_t kNone = ScanSheet::kNone;

std::uint64_t pair_key(std::uint32_t a, std::uint32_t b) { return (std::uint64_t{a} << 32) | b; }

class ScanMesher {
 public:
  ScanMesher(const Impl& surface, const Arrangement& arrangement, const ArcSamples& samples,
             const ScanSheet& sheet, const ScanArcs& arcs, const ScanMeshOptions& options)
      : surface_(surface),
        arrangement_(arrangement),
        samples_(samples),
        sheet_(sheet),
        arcs_(arcs),
        options_(options),
        local_vertex_(sheet.points.size(), kNone) {}

  Result<RegionMesh> run();

 private:
  std::uint32_t add(const Vec3& p, std::uint32_t arc_point) {
    mesh_.position.push_back(p);
    mesh_.arc_point.push_back(arc_point);
    mesh_.border_bound.push_back(0);
    return static_cast<std::uint32_t>(mesh_.position.size() - 1);
  }
  std::uint32_t local_arc_point(std::uint32_t p);
  std::uint32_t local_vertex(std::uint32_t v) {
    if (local_vertex_[v] == kNone) local_vertex_[v] = add(sheet_.points[v], ArcSamples::kNone);
    return local_vertex_[v];
  }
  [[nodiscard]] Label label_at(double x, double y) const { return surface_.evaluate(x, y).label; }

  void add_loops();
  void add_untouched();
  void add_touched();
  Status triangulate();
  void add_normals();

  const Impl& surface_;
  const Arrangement& arrangement_;
  const ArcSamples& samples_;
  const ScanSheet& sheet_;
  const ScanArcs& arcs_;
  const ScanMeshOptions& options_;
  RegionMesh mesh_;
  std::vector<std::uint32_t> local_vertex_;
  std::unordered_map<std::uint32_t, std::uint32_t> local_arc_;
  std::vector<PlanarTriangulation::Segment> segments_;
  std::size_t loop_segments_ = 0;
  std::unordered_set<std::uint64_t> on_loops_;
  std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> on_edge_;  // arc points, local
  std::vector<char> whole_;  // triangles taken as they are
};

std::uint32_t ScanMesher::local_arc_point(std::uint32_t p) {
  const auto [it, fresh] = local_arc_.try_emplace(p, kNone);
  if (!fresh) return it->second;
  const ArcPoint& point = samples_.points[p];
  std::uint32_t vertex = kNone;
  if (point.node != ArcPoint::kNoNode) {
    const ScanPlace& where = arcs_.place[point.node];
    if (where.kind == ScanPlace::Kind::kVertex) vertex = where.id;
  }
  if (vertex != kNone && local_vertex_[vertex] != kNone) {
    it->second = local_vertex_[vertex];
    return it->second;
  }
  it->second = add(samples_.at(p, mesh_.label), p);
  if (vertex != kNone) local_vertex_[vertex] = it->second;
  if (point.node != ArcPoint::kNoNode) {
    const ScanPlace& where = arcs_.place[point.node];
    if (where.kind == ScanPlace::Kind::kEdge) on_edge_[where.id].push_back(it->second);
  }
  return it->second;
}

// The arcs round the base, the base on their left.
void ScanMesher::add_loops() {
  std::vector<std::uint32_t> chain;
  for (const PlanRegion& region : arrangement_.regions) {
    if (!is_base(surface_, region.label)) continue;
    mesh_.label = region.label;
    for (const std::vector<ArcUse>& loop : region.loops) {
      for (const ArcUse& use : loop) {
        samples_.chain(use.arc, chain);
        if (!use.forward) std::reverse(chain.begin(), chain.end());
        for (std::size_t k = 0; k + 1 < chain.size(); ++k) {
          const std::uint32_t a = local_arc_point(chain[k]), b = local_arc_point(chain[k + 1]);
          if (a == b) continue;
          const double d = samples_.chord_bound(chain[k], chain[k + 1]);
          mesh_.border_bound[a] = std::fmax(mesh_.border_bound[a], d);
          mesh_.border_bound[b] = std::fmax(mesh_.border_bound[b], d);
          segments_.push_back({a, b});
          on_loops_.insert(pair_key(a, b));
          on_loops_.insert(pair_key(b, a));
        }
      }
    }
  }
  loop_segments_ = segments_.size();
}

// Triangles that no arc touches are seen or hidden as a whole.
void ScanMesher::add_untouched() {
  const std::size_t count = sheet_.triangles.size();
  whole_.assign(count, 0);
  parallel_blocks(count, 1024, options_.threads, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t t = begin; t < end; ++t) {
      if (arcs_.touched[t]) continue;
      const auto& of = sheet_.triangles[t];
      const Vec3 c = (sheet_.points[of[0]] + sheet_.points[of[1]] + sheet_.points[of[2]]) / 3;
      whole_[t] = is_base(surface_, label_at(c.x(), c.y())) ? 1 : 0;
    }
  });
  for (std::size_t t = 0; t < count; ++t) {
    if (!whole_[t]) continue;
    const auto& of = sheet_.triangles[t];
    mesh_.triangles.push_back({local_vertex(of[0]), local_vertex(of[1]), local_vertex(of[2])});
  }
}

// The edges of touched triangles, as far as they are seen.
void ScanMesher::add_touched() {
  std::vector<std::uint32_t> stops;
  for (std::uint32_t h = 0; h < sheet_.twin.size(); ++h) {
    const std::uint32_t twin = sheet_.twin[h];
    const bool here = arcs_.touched[h / 3] != 0;
    const bool there = twin != kNone && arcs_.touched[twin / 3] != 0;
    if (!here || twin == kNone || (there && twin < h)) continue;
    const std::uint32_t u = sheet_.from(h), v = sheet_.to(h);
    const Vec2 p = sheet_.points[u].head<2>(), d = sheet_.points[v].head<2>() - p;
    const auto found = on_edge_.find(std::min(h, twin));
    stops.clear();
    if (found != on_edge_.end()) stops = found->second;
    std::sort(stops.begin(), stops.end(), [&](std::uint32_t i, std::uint32_t j) {
      return d.dot(mesh_.position[i].head<2>() - p) < d.dot(mesh_.position[j].head<2>() - p);
    });
    Vec2 from = p;
    std::uint32_t from_local = kNone;
    for (std::size_t k = 0; k <= stops.size(); ++k) {
      const bool last = k == stops.size();
      const Vec2 to =
          last ? Vec2(sheet_.points[v].head<2>()) : Vec2(mesh_.position[stops[k]].head<2>());
      const Vec2 m = 0.5 * (from + to);
      if (is_base(surface_, label_at(m.x(), m.y()))) {
        const std::uint32_t a = from_local == kNone ? local_vertex(u) : from_local;
        const std::uint32_t b = last ? local_vertex(v) : stops[k];
        if (a != b && on_loops_.count(pair_key(a, b)) == 0) {
          segments_.push_back({a, b});
          if (there) segments_.push_back({b, a});
        }
      }
      from = to;
      if (!last) from_local = stops[k];
    }
  }
}

Status ScanMesher::triangulate() {
  if (segments_.empty()) return ok();
  // Only what the segments use.
  std::vector<std::uint32_t> number(mesh_.position.size(), kNone), used;
  std::vector<Vec2> points;
  const auto of = [&](std::uint32_t v) {
    if (number[v] == kNone) {
      number[v] = static_cast<std::uint32_t>(points.size());
      points.emplace_back(mesh_.position[v].head<2>());
      used.push_back(v);
    }
    return number[v];
  };
  std::vector<PlanarTriangulation::Segment> segments;
  for (const auto& s : segments_) segments.push_back({of(s[0]), of(s[1])});
  for (int attempt = 0; attempt < 40; ++attempt) {
    PlanarTriangulation triangulation;
    const std::vector<SegmentCrossing> wrong = triangulation.build(points, segments);
    if (wrong.empty()) {
      for (const auto& t : triangulation.triangles())
        mesh_.triangles.push_back({used[t[0]], used[t[1]], used[t[2]]});
      return ok();
    }
    // Edges of the sheet inside give way; what lies between is told below by the triangles
    // themselves.
    std::vector<char> drop(segments.size(), 0);
    bool any = false;
    for (const SegmentCrossing& w : wrong) {
      for (const std::uint32_t s : {w.segment_a, w.segment_b}) {
        if (s >= segments.size() || s < loop_segments_) continue;
        drop[s] = 1;
        any = true;
      }
    }
    if (!any) break;
    // Both directions of an edge go together.
    std::unordered_set<std::uint64_t> gone;
    for (std::size_t s = 0; s < segments.size(); ++s) {
      if (drop[s]) {
        gone.insert(pair_key(segments[s][0], segments[s][1]));
        gone.insert(pair_key(segments[s][1], segments[s][0]));
      }
    }
    std::vector<PlanarTriangulation::Segment> rest;
    for (std::size_t s = 0; s < segments.size(); ++s) {
      if (s < loop_segments_ || gone.count(pair_key(segments[s][0], segments[s][1])) == 0)
        rest.push_back(segments[s]);
    }
    segments = std::move(rest);
  }
  return Error{ErrorCode::kInput,
               "the border of the scanned base crosses itself at the least distance: the scan is "
               "finer than its coordinates can tell",
               {surface_.program.file}};
}

// Mean normals at the corners, by angle, over triangles that meet without a crease; and the
// creases.
void ScanMesher::add_normals() {
  const std::vector<std::array<std::uint32_t, 3>>& triangles = mesh_.triangles;
  std::vector<Vec3> flat(triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const Vec3 &a = mesh_.position[triangles[t][0]], &b = mesh_.position[triangles[t][1]],
               &c = mesh_.position[triangles[t][2]];
    // The sheet's own plane: slivers beside arcs have none to speak of.
    BaseHit hit;
    const Vec3 m = (a + b + c) / 3;
    flat[t] = surface_.base_at(m.x(), m.y(), hit) ? Vec3(-hit.zx, -hit.zy, 1).normalized()
                                                  : (b - a).cross(c - a).normalized();
  }
  DisjointSets corners(triangles.size() * 3);
  const double least = std::cos(options_.feature_angle);
  std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> crease;  // vertex to vertices
  const std::vector<EdgeUse> uses = edge_uses(triangles, mesh_.position.size());
  for_each_edge(uses, [&](std::span<const EdgeUse> edge) {
    if (edge.size() != 2) return;
    if (flat[edge[0].corner / 3].dot(flat[edge[1].corner / 3]) >= least) {
      corners.join(corner_at_low(edge[0]), corner_at_low(edge[1]));
      corners.join(corner_at_high(edge[0]), corner_at_high(edge[1]));
    } else {
      crease[edge[0].low].push_back(edge[0].high);
      crease[edge[0].high].push_back(edge[0].low);
    }
  });
  std::vector<std::uint32_t> index(triangles.size() * 3, kNone);
  mesh_.corner_normals.resize(triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t set = corners.find(3 * t + k);
      if (index[set] == kNone) {
        index[set] = static_cast<std::uint32_t>(mesh_.normals.size());
        mesh_.normals.emplace_back(Vec3::Zero());
      }
      const Vec3& p = mesh_.position[triangles[t][k]];
      const Vec3 u = mesh_.position[triangles[t][(k + 1) % 3]] - p,
                 v = mesh_.position[triangles[t][(k + 2) % 3]] - p;
      mesh_.normals[index[set]] += std::atan2(u.cross(v).norm(), u.dot(v)) * flat[t];
      mesh_.corner_normals[t][k] = index[set];
    }
  }
  for (Vec3& n : mesh_.normals) {
    const double length = n.norm();
    n = length > 0 ? Vec3(n / length) : Vec3::UnitZ();
  }
  // Chains from every end or junction of creases, then what is left: rings.
  std::vector<std::uint32_t> starts;
  for (const auto& [v, to] : crease) starts.push_back(v);
  std::sort(starts.begin(), starts.end());
  std::unordered_set<std::uint64_t> walked;
  const auto walk = [&](std::uint32_t from, std::uint32_t to) {
    if (!walked.insert(pair_key(std::min(from, to), std::max(from, to))).second) return;
    std::vector<std::uint32_t> chain{from, to};
    for (;;) {
      const std::vector<std::uint32_t>& ways = crease[chain.back()];
      if (ways.size() != 2 || chain.back() == chain.front()) break;
      const std::uint32_t next = ways[0] == chain[chain.size() - 2] ? ways[1] : ways[0];
      if (!walked.insert(pair_key(std::min(chain.back(), next), std::max(chain.back(), next)))
               .second)
        break;
      chain.push_back(next);
    }
    mesh_.creases.push_back(std::move(chain));
  };
  for (const bool rings : {false, true}) {
    for (const std::uint32_t v : starts) {
      if (!rings && crease[v].size() == 2) continue;
      const std::vector<std::uint32_t> ways = crease[v];
      for (const std::uint32_t w : ways) walk(v, w);
    }
  }
}

Result<RegionMesh> ScanMesher::run() {
  add_loops();
  if (segments_.empty()) return RegionMesh{};
  add_untouched();
  add_touched();
  if (const Status done = triangulate(); !done) return done.error();
  for (const auto& t : mesh_.triangles) {
    double bound = 0;
    for (const std::uint32_t v : t) bound = std::fmax(bound, mesh_.border_bound[v]);
    mesh_.largest_deviation = std::fmax(mesh_.largest_deviation, bound);
  }
  add_normals();
  return std::move(mesh_);
}

}  // namespace

Result<RegionMesh> mesh_scan(const Impl& surface, const Arrangement& arrangement,
                             const ArcSamples& samples, const ScanSheet& sheet,
                             const ScanArcs& arcs, const ScanMeshOptions& options) {
  return ScanMesher(surface, arrangement, samples, sheet, arcs, options).run();
}

}  // namespace diesink
