// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/scan_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <unordered_map>
#include <unordered_set>

#include "core/base/exact_plan.h"
#include "core/mesh_tools/topology.h"

namespace diesink {
namespace {

using Impl = CompoundSurface::Impl;
constexpr std::uint32_t kNone = ScanSheet::kNone;

std::uint64_t pair_key(std::uint32_t a, std::uint32_t b) { return (std::uint64_t{a} << 32) | b; }

class SheetSplitter {
 public:
  SheetSplitter(const Impl& surface, const Arrangement& arrangement, const ArcSamples& samples,
                const ScanSheet& sheet, const ScanArcs& arcs)
      : surface_(surface),
        arrangement_(arrangement),
        samples_(samples),
        sheet_(sheet),
        arcs_(arcs),
        touched_(arcs.touched) {}

  Result<ScanCut> run();

 private:
  std::uint32_t add(const Vec3& p, std::uint32_t arc_point) {
    out_.sheet.points.push_back(p);
    out_.arc_point.push_back(arc_point);
    return static_cast<std::uint32_t>(out_.sheet.points.size() - 1);
  }
  std::uint32_t local_arc_point(std::uint32_t p);
  std::uint32_t local_vertex(std::uint32_t v) {
    if (local_vertex_[v] == kNone) local_vertex_[v] = add(sheet_.points[v], ArcSamples::kNone);
    return local_vertex_[v];
  }

  void add_loops();
  void cover(const std::vector<std::uint32_t>& run, std::uint32_t end);
  void add_untouched();
  void add_touched();
  [[nodiscard]] double area_off_sheet(const std::array<std::uint32_t, 3>& t) const;
  Result<bool> triangulate();
  [[nodiscard]] Error crosses_itself() const;
  Status mark_seen();

  const Impl& surface_;
  const Arrangement& arrangement_;
  const ArcSamples& samples_;
  const ScanSheet& sheet_;
  const ScanArcs& arcs_;
  ScanCut out_;
  std::vector<std::uint32_t> local_vertex_;
  std::unordered_map<std::uint32_t, std::uint32_t> local_arc_;
  std::vector<PlanarTriangulation::Segment> segments_;
  std::vector<std::uint32_t> half_;  // of each: the sheet's half-edge it is part of, or kNone
  std::vector<char> touched_;
  std::unordered_set<std::uint64_t> on_loops_;  // directed, the base on their left
  std::unordered_set<std::uint64_t> covered_;   // ways that points of arcs divide, straight
  std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> on_edge_;  // arc points, local
};

std::uint32_t SheetSplitter::local_arc_point(std::uint32_t p) {
  const auto [it, fresh] = local_arc_.try_emplace(p, kNone);
  if (!fresh) return it->second;
  const ArcPoint& point = samples_.points[p];
  ScanPlace where;
  if (point.node != ArcPoint::kNoNode) where = arcs_.place[point.node];
  const std::uint32_t vertex = where.kind == ScanPlace::Kind::kVertex ? where.id : kNone;
  if (vertex != kNone && local_vertex_[vertex] != kNone) {
    it->second = local_vertex_[vertex];
    return it->second;
  }
  it->second = add(samples_.at(p, out_.label), p);
  if (vertex != kNone) local_vertex_[vertex] = it->second;
  if (where.kind == ScanPlace::Kind::kEdge) on_edge_[where.id].push_back(it->second);
  return it->second;
}

// The arcs round the base, the base on their left; what is hidden behind them on their right.
void SheetSplitter::add_loops() {
  for (const PlanRegion& region : arrangement_.regions) {
    if (!is_base(surface_, region.label)) continue;
    out_.label = region.label;
    for (const std::vector<ArcUse>& loop : region.loops) {
      for (const ArcUse& use : loop) {
        out_.uses.push_back(use);
        const PlanArc& arc = arrangement_.arcs[use.arc];
        const std::vector<ArcSample>& chain = samples_.arcs[use.arc].samples;
        std::uint32_t k = 0;
        std::vector<std::uint32_t> run;  // from one node on, points between nodes
        do {
          const std::uint32_t next = chain[k].next;
          if (next == ArcSample::kEnd) break;
          if (samples_.points[chain[k].point].node != ArcPoint::kNoNode) run.clear();
          run.push_back(local_arc_point(chain[k].point));
          if (run.size() > 1 && samples_.points[chain[next].point].node != ArcPoint::kNoNode)
            cover(run, local_arc_point(chain[next].point));
          const double t1 = next == 0 ? static_cast<double>(arc.nodes.size() - 1) : chain[next].t;
          const std::size_t stretch =
              std::min(static_cast<std::size_t>(0.5 * (chain[k].t + t1)), arc.curves.size() - 1);
          std::uint32_t a = local_arc_point(chain[k].point), b = local_arc_point(chain[next].point);
          k = next;
          if (a == b) continue;
          if (!use.forward) std::swap(a, b);
          if (!on_loops_.insert(pair_key(a, b)).second) continue;
          segments_.push_back({a, b});
          const bool ends = arc.border || arc.curves[stretch].type == CurveType::kOutline;
          if (!ends) segments_.push_back({b, a});
        } while (k != 0);
      }
    }
  }
  // Where the base is on both sides, each way is there twice.
  std::sort(segments_.begin(), segments_.end());
  segments_.erase(std::unique(segments_.begin(), segments_.end()), segments_.end());
  half_.assign(segments_.size(), kNone);
}

// A straight run of an arc between two nodes: an edge of the sheet from one to the other is the
// run.
void SheetSplitter::cover(const std::vector<std::uint32_t>& run, std::uint32_t end) {
  const std::vector<Vec3>& points = out_.sheet.points;
  const Vec2 a = points[run.front()].head<2>(), d = points[end].head<2>() - a;
  for (const std::uint32_t p : run) {
    const Vec2 q = points[p].head<2>() - a;
    if (!(std::fabs(d.x() * q.y() - d.y() * q.x()) <= 1e-10 * surface_.size * d.norm())) return;
  }
  covered_.insert(pair_key(run.front(), end));
  covered_.insert(pair_key(end, run.front()));
}

void SheetSplitter::add_untouched() {
  for (std::size_t t = 0; t < sheet_.triangles.size(); ++t) {
    if (touched_[t]) continue;
    const auto& of = sheet_.triangles[t];
    out_.sheet.triangles.push_back({local_vertex(of[0]), local_vertex(of[1]), local_vertex(of[2])});
  }
}

// The edges of touched triangles.
void SheetSplitter::add_touched() {
  std::unordered_set<std::uint64_t> on_loops;
  for (const auto& s : segments_) on_loops.insert(pair_key(s[0], s[1]));
  std::vector<std::uint32_t> stops;
  const std::vector<Vec3>& points = out_.sheet.points;
  for (std::uint32_t h = 0; h < sheet_.twin.size(); ++h) {
    const std::uint32_t twin = sheet_.twin[h];
    const bool here = touched_[h / 3] != 0;
    const bool there = twin != kNone && touched_[twin / 3] != 0;
    if (!here || (there && twin < h)) continue;
    const std::uint32_t u = sheet_.from(h), v = sheet_.to(h);
    const Vec2 p = sheet_.points[u].head<2>(), d = sheet_.points[v].head<2>() - p;
    const auto found = on_edge_.find(std::min(h, twin));
    stops.clear();
    if (found != on_edge_.end()) stops = found->second;
    std::sort(stops.begin(), stops.end(), [&](std::uint32_t i, std::uint32_t j) {
      return d.dot(points[i].head<2>() - p) < d.dot(points[j].head<2>() - p);
    });
    std::uint32_t a = local_vertex(u);
    for (std::size_t k = 0; k <= stops.size(); ++k) {
      const std::uint32_t b = k == stops.size() ? local_vertex(v) : stops[k];
      if (a == b) continue;
      const bool known = on_loops.count(pair_key(a, b)) != 0 ||
                         on_loops.count(pair_key(b, a)) != 0 || covered_.count(pair_key(a, b)) != 0;
      if (!known) {
        segments_.push_back({a, b});
        half_.push_back(h);
        if (there) {
          segments_.push_back({b, a});
          half_.push_back(h);
        }
      }
      a = b;
    }
  }
}

// The plan area of a triangle of the cut that is no piece of one of the sheet.
double SheetSplitter::area_off_sheet(const std::array<std::uint32_t, 3>& t) const {
  const Vec3 &a = out_.sheet.points[t[0]], &b = out_.sheet.points[t[1]],
             &c = out_.sheet.points[t[2]];
  const Vec3 m = (a + b + c) / 3;
  const double area = 0.5 * ((b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x()));
  BaseHit hit;
  if (!surface_.base_at(m.x(), m.y(), hit)) return area;
  for (const Vec3* p : {&a, &b, &c}) {
    const double z = hit.z + hit.zx * (p->x() - m.x()) + hit.zy * (p->y() - m.y());
    // As far as arcs' points are known.
    if (!(std::fabs(z - p->z()) <= 1e-9 * surface_.size)) return area;
  }
  return 0;
}

// Sheet edges run over points of arcs that lie on them, and give way to chords too close to them to
// be told apart. False where one of those parts the touched triangles from the rest: `touched_` has
// what is beyond then, and all begins anew.
Result<bool> SheetSplitter::triangulate() {
  if (segments_.empty()) return true;
  // Only what the segments use.
  std::vector<std::uint32_t> number(out_.sheet.points.size(), kNone), used;
  std::vector<Vec2> points;
  const auto of = [&](std::uint32_t v) {
    if (number[v] == kNone) {
      number[v] = static_cast<std::uint32_t>(points.size());
      points.emplace_back(out_.sheet.points[v].head<2>());
      used.push_back(v);
    }
    return number[v];
  };
  std::vector<PlanarTriangulation::Segment> segments;
  for (const auto& s : segments_) segments.push_back({of(s[0]), of(s[1])});
  std::vector<std::uint32_t> half = half_;
  bool proven = true;
  constexpr int kMostAttempts = 40;
  for (int attempt = 0; attempt < kMostAttempts; ++attempt) {
    PlanarTriangulation triangulation;
    const std::vector<SegmentCrossing> wrong = triangulation.build(points, segments);
    if (wrong.empty()) {
      for (const auto& t : triangulation.triangles()) {
        out_.sheet.triangles.push_back({used[t[0]], used[t[1]], used[t[2]]});
        if (!proven) out_.unproven_area += area_off_sheet(out_.sheet.triangles.back());
      }
      return true;
    }
    std::unordered_set<std::uint64_t> there, gone;
    for (const auto& s : segments) there.insert(pair_key(s[0], s[1]));
    std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> stops;  // by low and high end
    bool wider = false;
    for (const SegmentCrossing& w : wrong) {
      for (const std::uint32_t s : {w.segment_a, w.segment_b}) {
        if (s >= segments.size() || half[s] == kNone) continue;
        const auto [a, b] = segments[s];
        if (w.point != kNoPoint) {
          stops[pair_key(std::min(a, b), std::max(a, b))].push_back(w.point);
          continue;
        }
        gone.insert(pair_key(a, b));
        if (there.count(pair_key(b, a)) != 0) {
          gone.insert(pair_key(b, a));
          continue;
        }
        const std::uint32_t twin = sheet_.twin[half[s]];
        if (twin == kNone) return crosses_itself();
        touched_[twin / 3] = 1;
        wider = true;
      }
    }
    if (wider) return false;
    if (gone.empty() && stops.empty()) break;
    proven = proven && gone.empty();
    std::vector<PlanarTriangulation::Segment> rest;
    std::vector<std::uint32_t> rest_half;
    for (std::size_t s = 0; s < segments.size(); ++s) {
      const auto [a, b] = segments[s];
      if (half[s] != kNone && gone.count(pair_key(a, b)) != 0) continue;
      const auto over =
          half[s] == kNone ? stops.end() : stops.find(pair_key(std::min(a, b), std::max(a, b)));
      if (over == stops.end()) {
        rest.push_back(segments[s]);
        rest_half.push_back(half[s]);
        continue;
      }
      const Vec2 d = points[b] - points[a];
      std::vector<std::uint32_t> on = over->second;
      std::sort(on.begin(), on.end(), [&](std::uint32_t i, std::uint32_t j) {
        const double at_i = d.dot(points[i]), at_j = d.dot(points[j]);
        return at_i != at_j ? at_i < at_j : i < j;
      });
      on.erase(std::unique(on.begin(), on.end()), on.end());
      on.push_back(b);
      std::uint32_t from = a;
      for (const std::uint32_t to : on) {
        const bool known =
            there.count(pair_key(from, to)) != 0 || there.count(pair_key(to, from)) != 0;
        if (!known) {
          rest.push_back({from, to});
          rest_half.push_back(half[s]);
        }
        from = to;
      }
    }
    segments = std::move(rest);
    half = std::move(rest_half);
  }
  return crosses_itself();
}

Error SheetSplitter::crosses_itself() const {
  return {ErrorCode::kInput,
          "the border of the scanned base crosses itself at the least distance: the scan is finer "
          "than its coordinates can tell",
          {surface_.program.file}};
}

// What lies to the left of the arcs.
Status SheetSplitter::mark_seen() {
  ScanSheet& sheet = out_.sheet;
  sheet.make_twins();
  out_.base.assign(sheet.triangles.size(), 0);
  std::vector<char> at_loop(sheet.points.size(), 0);
  for (const std::uint64_t key : on_loops_) {
    at_loop[key >> 32] = 1;
    at_loop[key & 0xFFFFFFFFu] = 1;
  }
  const auto is_loop = [&](std::uint32_t a, std::uint32_t b) {
    return at_loop[a] && at_loop[b] && on_loops_.count(pair_key(a, b)) != 0;
  };
  std::vector<std::uint32_t> open;
  for (std::uint32_t h = 0; h < sheet.twin.size(); ++h) {
    if (out_.base[h / 3] || !is_loop(sheet.from(h), sheet.to(h))) continue;
    out_.base[h / 3] = 1;
    open.push_back(h / 3);
    while (!open.empty()) {
      const std::uint32_t t = open.back();
      open.pop_back();
      for (std::uint32_t e = 3 * t; e < 3 * t + 3; ++e) {
        const std::uint32_t twin = sheet.twin[e];
        if (twin == kNone || out_.base[twin / 3]) continue;
        const std::uint32_t a = sheet.from(e), b = sheet.to(e);
        if (is_loop(a, b)) continue;
        if (is_loop(b, a)) {
          return Error{ErrorCode::kInput,
                       "what is seen of the scanned base is not parted from what is hidden",
                       {surface_.program.file}};
        }
        out_.base[twin / 3] = 1;
        open.push_back(twin / 3);
      }
    }
  }
  return ok();
}

Result<ScanCut> SheetSplitter::run() {
  for (;;) {
    out_ = {};
    local_vertex_.assign(sheet_.points.size(), kNone);
    local_arc_.clear();
    segments_.clear();
    half_.clear();
    on_loops_.clear();
    covered_.clear();
    on_edge_.clear();
    add_loops();
    if (segments_.empty()) return std::move(out_);
    add_untouched();
    add_touched();
    const Result<bool> done = triangulate();
    if (!done) return done.error();
    if (*done) break;
  }
  if (const Status done = mark_seen(); !done) return done.error();
  return std::move(out_);
}

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
      const bool end = k == 0 || chain[k].next == ArcSample::kEnd || arrangement.arcs[a].seam;
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

Result<ScanCut> cut_sheet(const Impl& surface, const Arrangement& arrangement,
                          const ArcSamples& samples, const ScanSheet& sheet, const ScanArcs& arcs) {
  return SheetSplitter(surface, arrangement, samples, sheet, arcs).run();
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
