// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/scan_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <unordered_set>

#include "core/base/exact_plan.h"
#include "core/mesh_tools/topology.h"
#include "core/pair_key.h"

namespace diesink {
namespace {

using Impl = CompoundSurface::Impl;
constexpr std::uint32_t kNone = ScanSheet::kNone;

// Which points of arcs may go from the border of the base.
class BorderRule {
 public:
  BorderRule(const ScanCut& cut, const Arrangement& arrangement, const ArcSamples& samples,
             double sag);
  bool may_straighten(std::uint32_t a, std::uint32_t v, std::uint32_t b, double share) const;
  void straighten(std::uint32_t v);

  std::vector<char> fixed;  // of the cut's vertices
  std::vector<char> gone;   // of the points of arcs

 private:
  // A point's own place in the one arc it is inside of.
  struct Place {
    std::uint32_t arc = kNone, sample = 0;
  };
  [[nodiscard]] std::size_t column(double x) const {
    return static_cast<std::size_t>(std::clamp((x - x0_) * scale_, 0.0, cells_ - 1.0));
  }
  [[nodiscard]] std::size_t line(double y) const {
    return static_cast<std::size_t>(std::clamp((y - y0_) * scale_, 0.0, cells_ - 1.0));
  }

  const ScanCut& cut_;
  const ArcSamples& samples_;
  double sag_;
  std::vector<Place> place_;                                // of points
  std::vector<std::vector<std::uint32_t>> before_, after_;  // of each arc's samples: what is left
  // All points of arcs by cells of the plan.
  double x0_ = 0, y0_ = 0, scale_ = 0, cells_ = 1;
  std::vector<std::uint32_t> start_, items_;
};

BorderRule::BorderRule(const ScanCut& cut, const Arrangement& arrangement,
                       const ArcSamples& samples, double sag)
    : fixed(cut.sheet.points.size(), 0),
      gone(samples.points.size(), 0),
      cut_(cut),
      samples_(samples),
      sag_(sag),
      place_(samples.points.size()),
      before_(samples.arcs.size()),
      after_(samples.arcs.size()) {
  // Points that more than one arc has, or the base on both sides, stay.
  std::vector<int> count(samples.points.size(), 0);
  for (std::uint32_t a = 0; a < samples.arcs.size(); ++a) {
    const std::vector<ArcSample>& chain = samples.arcs[a].samples;
    before_[a].assign(chain.size(), kNone);
    after_[a].assign(chain.size(), kNone);
    for (std::uint32_t k = 0; k < chain.size(); ++k) {
      const bool end = k == 0 || chain[k].next == ArcSample::kEnd || arrangement.arcs[a].fixed;
      count[chain[k].point] += end ? 2 : 1;
      place_[chain[k].point] = {a, k};
      if (chain[k].next == ArcSample::kEnd) continue;
      after_[a][k] = chain[k].next;
      before_[a][chain[k].next] = k;
    }
  }
  std::vector<char> used(arrangement.arcs.size(), 0);
  for (const ArcUse& use : cut.uses) {
    if (used[use.arc]++ == 0) continue;
    for (const ArcSample& s : samples.arcs[use.arc].samples) count[s.point] += 2;
  }
  for (std::size_t v = 0; v < fixed.size(); ++v) {
    const std::uint32_t p = cut.arc_point[v];
    if (p != ArcSamples::kNone && count[p] != 1) fixed[v] = 1;
  }
  // The grid.
  PlanBox box{HUGE_VAL, -HUGE_VAL, HUGE_VAL, -HUGE_VAL};
  for (const ArcPoint& p : samples.points) {
    box = {std::fmin(box.x0, p.x), std::fmax(box.x1, p.x), std::fmin(box.y0, p.y),
           std::fmax(box.y1, p.y)};
  }
  cells_ = std::ceil(std::sqrt(static_cast<double>(samples.points.size()) + 1));
  x0_ = box.x0;
  y0_ = box.y0;
  const double extent = std::fmax(box.x1 - box.x0, box.y1 - box.y0);
  scale_ = extent > 0 ? cells_ / extent : 0;
  const auto per_row = static_cast<std::size_t>(cells_);
  start_.assign(per_row * per_row + 2, 0);
  items_.resize(samples.points.size());
  const auto cell = [&](const ArcPoint& p) { return line(p.y) * per_row + column(p.x); };
  for (const ArcPoint& p : samples.points) ++start_[cell(p) + 2];
  for (std::size_t c = 2; c < start_.size(); ++c) start_[c] += start_[c - 1];
  for (std::uint32_t p = 0; p < items_.size(); ++p)
    items_[start_[cell(samples.points[p]) + 1]++] = p;
}

bool BorderRule::may_straighten(std::uint32_t a, std::uint32_t v, std::uint32_t b,
                                double share) const {
  const std::uint32_t p = cut_.arc_point[v];
  if (p == ArcSamples::kNone) return false;
  const auto [arc, sample] = place_[p];
  const std::uint32_t from = before_[arc][sample], to = after_[arc][sample];
  if (from == kNone || to == kNone) return false;
  const std::vector<ArcSample>& chain = samples_.arcs[arc].samples;
  const std::uint32_t pa = cut_.arc_point[a], pb = cut_.arc_point[b];
  const bool along = chain[from].point == pa && chain[to].point == pb;
  const bool against = chain[from].point == pb && chain[to].point == pa;
  if (!along && !against) return false;
  if (!(samples_.span_bound(arc, from, to) <= share * sag_)) return false;
  // Nothing of another border, or of this one farther on, may lie where the border moves over.
  const ArcPoint* corner[3] = {&samples_.points[pa], &samples_.points[p], &samples_.points[pb]};
  const int turned =
      turn(corner[0]->x, corner[0]->y, corner[1]->x, corner[1]->y, corner[2]->x, corner[2]->y);
  if (turned < 0) std::swap(corner[0], corner[2]);
  const double t0 = chain[from].t, t1 = to == 0 ? HUGE_VAL : chain[to].t;
  const std::size_t i0 = column(std::fmin(corner[0]->x, std::fmin(corner[1]->x, corner[2]->x)));
  const std::size_t i1 = column(std::fmax(corner[0]->x, std::fmax(corner[1]->x, corner[2]->x)));
  const std::size_t j0 = line(std::fmin(corner[0]->y, std::fmin(corner[1]->y, corner[2]->y)));
  const std::size_t j1 = line(std::fmax(corner[0]->y, std::fmax(corner[1]->y, corner[2]->y)));
  const auto per_row = static_cast<std::size_t>(cells_);
  for (std::size_t j = j0; j <= j1; ++j) {
    for (std::size_t i = i0; i <= i1; ++i) {
      for (std::uint32_t k = start_[j * per_row + i]; k < start_[j * per_row + i + 1]; ++k) {
        const std::uint32_t other = items_[k];
        if (other == pa || other == pb || other == p) continue;
        const Place& at = place_[other];
        if (at.arc == arc && chain[at.sample].t >= t0 && chain[at.sample].t <= t1) continue;
        const ArcPoint& q = samples_.points[other];
        bool outside = false;
        for (std::size_t e = 0; e < 3 && !outside; ++e) {
          const ArcPoint &c = *corner[e], &d = *corner[(e + 1) % 3];
          outside = turn(c.x, c.y, d.x, d.y, q.x, q.y) < 0;
        }
        if (!outside) return false;
      }
    }
  }
  return true;
}

void BorderRule::straighten(std::uint32_t v) {
  const std::uint32_t p = cut_.arc_point[v];
  if (p == ArcSamples::kNone) return;
  gone[p] = 1;
  const auto [arc, sample] = place_[p];
  const std::uint32_t from = before_[arc][sample], to = after_[arc][sample];
  after_[arc][from] = to;
  before_[arc][to] = from;
}

// Mean normals at the corners, by angle, over triangles that meet without a crease; and the
// creases.
void add_normals(double feature_angle, RegionMesh& mesh) {
  const std::vector<std::array<std::uint32_t, 3>>& triangles = mesh.triangles;
  std::vector<Vec3> flat(triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const Vec3 &a = mesh.position[triangles[t][0]], &b = mesh.position[triangles[t][1]],
               &c = mesh.position[triangles[t][2]];
    flat[t] = (b - a).cross(c - a).normalized();
  }
  DisjointSets corners(triangles.size() * 3);
  const double least = std::cos(feature_angle);
  std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> crease;  // vertex to vertices
  const std::vector<EdgeUse> uses = edge_uses(triangles, mesh.position.size());
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
  mesh.corner_normals.resize(triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t set = corners.find(3 * t + k);
      if (index[set] == kNone) {
        index[set] = static_cast<std::uint32_t>(mesh.normals.size());
        mesh.normals.emplace_back(Vec3::Zero());
      }
      const Vec3& p = mesh.position[triangles[t][k]];
      const Vec3 u = mesh.position[triangles[t][(k + 1) % 3]] - p,
                 v = mesh.position[triangles[t][(k + 2) % 3]] - p;
      mesh.normals[index[set]] += std::atan2(u.cross(v).norm(), u.dot(v)) * flat[t];
      mesh.corner_normals[t][k] = index[set];
    }
  }
  for (Vec3& n : mesh.normals) {
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
    mesh.creases.push_back(std::move(chain));
  };
  for (const bool rings : {false, true}) {
    for (const std::uint32_t v : starts) {
      if (!rings && crease[v].size() == 2) continue;
      const std::vector<std::uint32_t> ways = crease[v];
      for (const std::uint32_t w : ways) walk(v, w);
    }
  }
}

}  // namespace

double largest_bound(const ArcSamples& samples, const ScanCut& cut) {
  double most = 0;
  for (const ArcUse& use : cut.uses) {
    for (const ArcSample& s : samples.arcs[use.arc].samples) {
      if (s.next != ArcSample::kEnd) most = std::fmax(most, s.deviation);
    }
  }
  return most;
}

double thin_cut(ScanCut& cut, const Arrangement& arrangement, ArcSamples& samples,
                ThinOptions options, double sag) {
  if (cut.label == kNoLabel) return 0;
  BorderRule rule(cut, arrangement, samples, sag);
  options.part = cut.base;
  options.fixed = rule.fixed;
  options.may_straighten = [&](std::uint32_t a, std::uint32_t v, std::uint32_t b, double share) {
    return rule.may_straighten(a, v, b, share);
  };
  options.straightened = [&](std::uint32_t v) { rule.straighten(v); };
  std::vector<std::uint32_t> kept;
  const double deviation = thin_sheet(cut.sheet, options, &kept);
  std::vector<std::uint32_t> arc_point;
  for (const std::uint32_t v : kept) arc_point.push_back(cut.arc_point[v]);
  cut.arc_point = std::move(arc_point);
  cut.base.assign(cut.sheet.triangles.size(), 1);
  samples.drop(rule.gone);
  return deviation;
}

RegionMesh mesh_base(const ArcSamples& samples, const ScanCut& cut, double feature_angle) {
  RegionMesh mesh;
  if (cut.label == kNoLabel || cut.sheet.triangles.empty()) return mesh;
  mesh.label = cut.label;
  mesh.position = cut.sheet.points;
  mesh.arc_point = cut.arc_point;
  mesh.border_bound.assign(mesh.position.size(), 0);
  mesh.triangles = cut.sheet.triangles;
  mesh.unproven_area = cut.unproven_area;
  mesh.largest_deviation = largest_bound(samples, cut);
  add_normals(feature_angle, mesh);
  return mesh;
}

}  // namespace diesink
