// A scanned sheet cut along the arcs of the arrangement: which of its triangles are seen.
// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <unordered_set>
#include <variant>

#include "core/base/exact_plan.h"
#include "core/pair_key.h"
#include "core/tessellate/scan_mesh.h"
#include "core/tessellate/sheet_offset.h"

namespace diesink {
namespace {

using Impl = CompoundSurface::Impl;
constexpr std::uint32_t kNone = ScanSheet::kNone;

class SheetSplitter {
 public:
  SheetSplitter(const Impl& surface, const Arrangement& arrangement, const ArcSamples& samples,
                const ScanSheet& sheet, const ScanArcs& arcs, double most_off)
      : surface_(surface),
        arrangement_(arrangement),
        samples_(samples),
        sheet_(sheet),
        arcs_(arcs),
        most_off_(most_off),
        inside_(sheet.triangles.size()),
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
  bool add_beyond();
  void add_untouched();
  void add_touched();
  Result<bool> triangulate();
  [[nodiscard]] Error crosses_itself() const;
  Status mark_seen();
  void measure_unproven();
  [[nodiscard]] bool has_beyond() const { return sheet_.triangles.size() > inside_; }

  const Impl& surface_;
  const Arrangement& arrangement_;
  const ArcSamples& samples_;
  ScanSheet sheet_;
  const ScanArcs& arcs_;
  double most_off_;
  std::size_t inside_;          // triangles of the scan; what follows lies beyond its border
  bool wants_beyond_ = false;   // a chord passes over the border
  std::vector<char> doubtful_;  // of the cut's triangles: may be no piece of one of the sheet
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
          if (!ends || has_beyond()) segments_.push_back({b, a});
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

// What lies beyond the border of the sheet as triangles, too, as far as a frame round all. Chords
// that pass over the border cut them as they cut the scan; of what is seen there the area is told.
// False where the border crosses itself.
bool SheetSplitter::add_beyond() {
  std::vector<std::uint32_t> number(sheet_.points.size(), kNone), used;
  std::vector<Vec2> points;
  PlanBox box = arrangement_.box;
  double low = HUGE_VAL;
  const auto of = [&](std::uint32_t v) {
    if (number[v] == kNone) {
      number[v] = static_cast<std::uint32_t>(points.size());
      const Vec3& p = sheet_.points[v];
      points.emplace_back(p.head<2>());
      used.push_back(v);
      box = {std::fmin(box.x0, p.x()), std::fmax(box.x1, p.x()), std::fmin(box.y0, p.y()),
             std::fmax(box.y1, p.y())};
      low = std::fmin(low, p.z());
    }
    return number[v];
  };
  std::vector<PlanarTriangulation::Segment> segments;
  for (std::uint32_t h = 0; h < sheet_.twin.size(); ++h) {
    if (sheet_.twin[h] == kNone) segments.push_back({of(sheet_.to(h)), of(sheet_.from(h))});
  }
  const double margin = 0.1 * (box.x1 - box.x0 + box.y1 - box.y0);
  const auto frame = static_cast<std::uint32_t>(points.size());
  for (const Vec2& p :
       {Vec2(box.x0 - margin, box.y0 - margin), Vec2(box.x1 + margin, box.y0 - margin),
        Vec2(box.x1 + margin, box.y1 + margin), Vec2(box.x0 - margin, box.y1 + margin)}) {
    points.push_back(p);
    used.push_back(static_cast<std::uint32_t>(sheet_.points.size()));
    sheet_.points.emplace_back(p.x(), p.y(), low);
  }
  for (std::uint32_t k = 0; k < 4; ++k) segments.push_back({frame + k, frame + (k + 1) % 4});
  PlanarTriangulation beyond;
  if (!beyond.build(points, segments).empty()) return false;
  for (const auto& t : beyond.triangles())
    sheet_.triangles.push_back({used[t[0]], used[t[1]], used[t[2]]});
  sheet_.make_twins();
  touched_.resize(sheet_.triangles.size(), 1);
  return true;
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

// Sheet edges run over points of arcs that lie on them, and give way to chords too close to them to
// be told apart, as vertices do. False where one of those parts the touched triangles from the
// rest: `touched_` has what is beyond then, and all begins anew.
Result<bool> SheetSplitter::triangulate() {
  if (segments_.empty()) return true;
  // Only what the segments use.
  std::vector<std::uint32_t> used;
  std::vector<Vec2> points;
  std::vector<PlanarTriangulation::Segment> segments;
  std::vector<char> on_loop;  // of the points
  std::vector<std::uint32_t> half = half_;
  const auto number = [&](const std::vector<PlanarTriangulation::Segment>& of_sheet) {
    std::vector<std::uint32_t> number_of(out_.sheet.points.size(), kNone);
    const auto of = [&](std::uint32_t v) {
      if (number_of[v] == kNone) {
        number_of[v] = static_cast<std::uint32_t>(points.size());
        points.emplace_back(out_.sheet.points[v].head<2>());
        used.push_back(v);
      }
      return number_of[v];
    };
    used.clear();
    points.clear();
    segments.clear();
    for (const auto& s : of_sheet) segments.push_back({of(s[0]), of(s[1])});
    on_loop.assign(points.size(), 0);
    for (std::size_t s = 0; s < segments.size(); ++s) {
      if (half[s] == kNone) on_loop[segments[s][0]] = on_loop[segments[s][1]] = 1;
    }
  };
  number(segments_);
  bool proven = true;
  constexpr int kMostAttempts = 40;
  for (int attempt = 0; attempt < kMostAttempts; ++attempt) {
    PlanarTriangulation triangulation;
    const std::vector<SegmentCrossing> wrong = triangulation.build(points, segments);
    if (wrong.empty()) {
      for (const auto& t : triangulation.triangles()) {
        out_.sheet.triangles.push_back({used[t[0]], used[t[1]], used[t[2]]});
      }
      doubtful_.resize(out_.sheet.triangles.size(), !proven || has_beyond() ? 1 : 0);
      return true;
    }
    std::unordered_set<std::uint64_t> there, gone;
    for (const auto& s : segments) there.insert(pair_key(s[0], s[1]));
    std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> stops;  // by low and high end
    bool wider = false;
    // An edge of the sheet gives way; false where it is the border's.
    const auto give_way = [&](std::size_t s) {
      const auto [a, b] = segments[s];
      gone.insert(pair_key(a, b));
      if (there.count(pair_key(b, a)) != 0) {
        gone.insert(pair_key(b, a));
        return true;
      }
      const std::uint32_t twin = sheet_.twin[half[s]];
      if (twin == kNone) return false;
      touched_[twin / 3] = 1;
      wider = true;
      return true;
    };
    bool at_border = false;
    std::vector<char> in_way(points.size(), 0);  // of vertices of the sheet
    bool any_in_way = false;
    const auto leave_out = [&](std::uint32_t p) {
      if (p >= points.size() || on_loop[p]) return;
      in_way[p] = 1;
      any_in_way = true;
    };
    for (const SegmentCrossing& w : wrong) {
      if (w.other_point != kNoPoint) {  // two at one place: the arc's stays
        leave_out(w.other_point);
        if (!in_way[w.other_point]) leave_out(w.point);
        continue;
      }
      const bool chord = w.segment_a < segments.size() && half[w.segment_a] == kNone;
      if (w.point != kNoPoint && chord) leave_out(w.point);
      for (const std::uint32_t s : {w.segment_a, w.segment_b}) {
        if (s >= segments.size() || half[s] == kNone) continue;
        const auto [a, b] = segments[s];
        if (w.point != kNoPoint) {
          stops[pair_key(std::min(a, b), std::max(a, b))].push_back(w.point);
        } else {
          at_border = !give_way(s) || at_border;
        }
      }
    }
    // A vertex of the sheet under a chord of an arc, but no point of it, goes with all its edges.
    for (std::size_t s = 0; any_in_way && s < segments.size(); ++s) {
      if (half[s] != kNone && (in_way[segments[s][0]] || in_way[segments[s][1]]))
        at_border = !give_way(s) || at_border;
    }
    if (at_border) {
      if (has_beyond()) return crosses_itself();
      wants_beyond_ = true;
      return false;
    }
    if (wider) return false;
    if (gone.empty() && stops.empty() && !any_in_way) {
      if (has_beyond()) break;
      wants_beyond_ = true;  // loops that run beside the border instead of along it
      return false;
    }
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
    half = std::move(rest_half);
    segments = std::move(rest);
    if (any_in_way) {
      for (auto& [a, b] : segments) {
        a = used[a];
        b = used[b];
      }
      number(std::vector(segments));
    }
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

// Of the triangles that may be no piece of one of the sheet: how far they are off it, if not too
// far, or else what of the plan they cover.
void SheetSplitter::measure_unproven() {
  const auto& scan = std::get<ScannedSurface>(surface_.base);
  for (std::size_t t = 0; t < doubtful_.size(); ++t) {
    if (!doubtful_[t] || !out_.base[t]) continue;
    const std::array<std::uint32_t, 3>& v = out_.sheet.triangles[t];
    const Vec3 &a = out_.sheet.points[v[0]], &b = out_.sheet.points[v[1]],
               &c = out_.sheet.points[v[2]];
    const SheetOffset offset = sheet_offset(scan, {a, b, c});
    if (offset.height <= most_off_) {
      out_.off_sheet = std::fmax(out_.off_sheet, offset.height);
      out_.unproven_area += offset.beyond;
    } else {
      out_.unproven_area +=
          0.5 * ((b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x()));
    }
  }
}

Result<ScanCut> SheetSplitter::run() {
  for (;;) {
    if (wants_beyond_ && !has_beyond() && !add_beyond()) return crosses_itself();
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
    doubtful_.assign(out_.sheet.triangles.size(), 0);
    add_touched();
    const Result<bool> done = triangulate();
    if (!done) return done.error();
    if (*done) break;
  }
  if (const Status done = mark_seen(); !done) return done.error();
  measure_unproven();
  return std::move(out_);
}

}  // namespace

Result<ScanCut> cut_sheet(const Impl& surface, const Arrangement& arrangement,
                          const ArcSamples& samples, const ScanSheet& sheet, const ScanArcs& arcs,
                          double most_off) {
  return SheetSplitter(surface, arrangement, samples, sheet, arcs, most_off).run();
}

}  // namespace diesink
