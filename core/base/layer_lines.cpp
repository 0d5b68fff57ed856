// Where lines of one layer pass over another: rims, and what is seen.
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <span>
#include <unordered_map>

#include "core/base/exact_plan.h"
#include "core/base/layer_joiner.h"
#include "core/mesh_tools/topology.h"

namespace diesink {
namespace {

constexpr std::uint32_t kNone = ScanSheet::kNone;

}  // namespace

PlanBox LayerJoiner::box_of(std::initializer_list<std::uint32_t> vertices, double more) const {
  PlanBox box{HUGE_VAL, -HUGE_VAL, HUGE_VAL, -HUGE_VAL};
  for (const std::uint32_t v : vertices) {
    const Vec3& p = sheet_.points[v];
    box = {std::fmin(box.x0, p.x() - more), std::fmax(box.x1, p.x() + more),
           std::fmin(box.y0, p.y() - more), std::fmax(box.y1, p.y() + more)};
  }
  return box;
}

// Edges with faces on one side alone in plan, beyond which something lies that is not higher.
void LayerJoiner::find_rims() {
  std::vector<std::array<std::uint32_t, 3>> flat;
  for (const auto& f : faces_) {
    if (f[0] != kNone) flat.push_back(f);
  }
  std::vector<Rim> candidates;
  const std::vector<EdgeUse> uses = edge_uses(flat, sheet_.points.size());
  for_each_edge(uses, [&](std::span<const EdgeUse> edge) {
    bool left = false, right = false;
    for (const EdgeUse& use : edge) (use.forward ? left : right) = true;
    if (left == right) return;
    candidates.push_back(left ? Rim{edge[0].low, edge[0].high} : Rim{edge[0].high, edge[0].low});
  });
  std::vector<std::uint32_t> over;
  std::vector<Vec2> polygon, cut;
  for (const Rim& rim : candidates) {
    const Vec3 &a = sheet_.points[rim.a], &b = sheet_.points[rim.b];
    const Vec2 d = (b - a).head<2>().normalized(), out(d.y(), -d.x());
    const Vec2 corner[4] = {a.head<2>(), a.head<2>() + lean_ * out, b.head<2>() + lean_ * out,
                            b.head<2>()};
    scan_.faces_over(box_of({rim.a, rim.b}, lean_), over);
    bool lower = false;
    for (const std::uint32_t f : over) {
      const auto& t = faces_[f];
      if (t[0] == kNone) continue;
      polygon.assign(corner, corner + 4);
      for (std::size_t k = 0; k < 3 && !polygon.empty(); ++k) {
        const Vec2 from = plan(t[k]), along = plan(t[(k + 1) % 3]) - from;
        cut.clear();
        for (std::size_t i = 0; i < polygon.size(); ++i) {
          const Vec2 &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
          const double lp = cross(along, p - from), lq = cross(along, q - from);
          if (lp >= 0) cut.push_back(p);
          if ((lp > 0 && lq < 0) || (lp < 0 && lq > 0)) cut.push_back(p + lp / (lp - lq) * (q - p));
        }
        polygon.swap(cut);
      }
      if (polygon.size() < 3) continue;
      double area = 0;
      for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
        area += cross(polygon[i] - polygon[0], polygon[i + 1] - polygon[0]);
      if (!(area > snap_ * snap_)) continue;
      const Vec3 &p = sheet_.points[t[0]], &q = sheet_.points[t[1]], &r = sheet_.points[t[2]];
      const double whole = cross((q - p).head<2>(), (r - p).head<2>());
      for (const Vec2& m : polygon) {
        const double wq = cross(m - p.head<2>(), (r - p).head<2>()) / whole;
        const double wr = cross((q - p).head<2>(), m - p.head<2>()) / whole;
        const double z = p.z() + wq * (q.z() - p.z()) + wr * (r.z() - p.z());
        lower = lower || z < height_on(rim, m) + snap_;
      }
      if (lower) break;
    }
    if (lower) rims_.push_back(rim);
  }
}

double LayerJoiner::height_on(const Rim& rim, const Vec2& p) const {
  const Vec3 &a = sheet_.points[rim.a], &b = sheet_.points[rim.b];
  const Vec2 d = (b - a).head<2>();
  const double s = std::clamp(d.dot(p - a.head<2>()) / d.squaredNorm(), 0.0, 1.0);
  return a.z() + s * (b.z() - a.z());
}

// What stays as it is, what may be seen in part, and what is hidden altogether: under something,
// and no rim passes over it.
void LayerJoiner::choose_faces(const std::vector<char>& marks) {
  part_.assign(faces_.size(), Part::kWhole);
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    if ((marks[f] & ScannedSurface::Layers::kUnder) != 0) part_[f] = Part::kHidden;
    if ((marks[f] & ScannedSurface::Layers::kCrosses) != 0) part_[f] = Part::kJoined;
    if (faces_[f][0] == kNone) part_[f] = Part::kHidden;
  }
  // Whatever a rim runs along or ends at has a wall there.
  std::vector<std::uint32_t> over;
  for (const Rim& rim : rims_) {
    scan_.faces_over(box_of({rim.a, rim.b}, snap_), over);
    const Vec2 a = plan(rim.a), b = plan(rim.b), d = (b - a).normalized();
    for (const std::uint32_t f : over) {
      const auto& t = faces_[f];
      if (t[0] == kNone || part_[f] == Part::kJoined) continue;
      // Apart where a side of the face has all of the rim beyond it, or the rim all of the face on
      // one side.
      bool apart = false;
      for (std::size_t k = 0; k < 3 && !apart; ++k) {
        const Vec2 from = plan(t[k]), along = (plan(t[(k + 1) % 3]) - from).normalized();
        apart = cross(along, a - from) < -snap_ && cross(along, b - from) < -snap_;
      }
      int left = 0, right = 0;
      for (const std::uint32_t v : t) {
        const double off = cross(d, plan(v) - a);
        left += off > snap_;
        right += off < -snap_;
      }
      if (!apart && left < 3 && right < 3) part_[f] = Part::kJoined;
    }
  }
}

void LayerJoiner::add_lines(const std::vector<std::array<Vec3, 2>>& meets) {
  struct Sides {
    bool whole = false, joined = false, rim = false;
  };
  std::unordered_map<std::uint64_t, Sides> edges;
  for (const Rim& rim : rims_) edges[key(rim.a, rim.b)].rim = true;
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    if (part_[f] != Part::kJoined) continue;
    for (std::size_t k = 0; k < 3; ++k)
      edges[key(faces_[f][k], faces_[f][(k + 1) % 3])].joined = true;
  }
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    if (part_[f] != Part::kWhole) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto it = edges.find(key(faces_[f][k], faces_[f][(k + 1) % 3]));
      if (it != edges.end()) it->second.whole = true;
    }
  }
  std::vector<std::uint64_t> keys;
  for (const auto& [k, sides] : edges) {
    if (sides.joined || (sides.rim && sides.whole)) keys.push_back(k);
  }
  std::sort(keys.begin(), keys.end());
  for (const std::uint64_t k : keys) {
    Line line;
    line.a = static_cast<std::uint32_t>(k >> 32);
    line.b = static_cast<std::uint32_t>(k & 0xFFFFFFFFu);
    line.fixed = edges[k].whole;
    lines_.push_back(line);
  }
  for (const auto& [p, q] : meets) {
    Line line;
    line.a = add_point(p);
    line.b = add_point(q);
    if ((q - p).head<2>().norm() > snap_) lines_.push_back(line);
  }
}

// Where two lines pass over one another or touch, in plan.
void LayerJoiner::cut_pair(std::uint32_t i, std::uint32_t j) {
  Line &f = lines_[i], &g = lines_[j];
  if (f.fixed && g.fixed) return;
  const Vec2 a = plan(f.a), b = plan(f.b), c = plan(g.a), d = plan(g.b);
  const Vec2 u = b - a, v = d - c;
  const double lu = u.norm(), lv = v.norm();
  if (!(lu > 0) || !(lv > 0)) return;
  // Ends of one on the other.
  bool touch = false;
  const auto touches = [&](Line& line, const Vec2& from, const Vec2& along, double length,
                           std::uint32_t end) {
    if (end == line.a || end == line.b) {
      touch = true;
      return;
    }
    const Vec2 p = plan(end) - from;
    const double s = along.dot(p) / (length * length);
    if (std::fabs(cross(along, p)) > snap_ * length || s * length < -snap_ ||
        (s - 1) * length > snap_)
      return;
    touch = true;
    if (!(s * length > snap_ && (1 - s) * length > snap_)) return;
    // Over or under the line's own point there: the topmost at one place counts in the end.
    const double own = height_on({line.a, line.b}, plan(end));
    std::uint32_t stop = end;
    if (std::fabs(own - sheet_.points[end].z()) > snap_)
      stop = add_point({plan(end).x(), plan(end).y(), own});
    line.stops.emplace_back(s, stop);
  };
  touches(f, a, u, lu, g.a);
  touches(f, a, u, lu, g.b);
  touches(g, c, v, lv, f.a);
  touches(g, c, v, lv, f.b);
  if (touch) return;
  if (turn(a.x(), a.y(), b.x(), b.y(), c.x(), c.y()) *
              turn(a.x(), a.y(), b.x(), b.y(), d.x(), d.y()) >=
          0 ||
      turn(c.x(), c.y(), d.x(), d.y(), a.x(), a.y()) *
              turn(c.x(), c.y(), d.x(), d.y(), b.x(), b.y()) >=
          0)
    return;
  const double s = cross(c - a, v) / cross(u, v);
  const Vec2 p = a + s * u;
  const double t = v.dot(p - c) / (lv * lv);
  const double own = std::fmax(height_on({f.a, f.b}, p), height_on({g.a, g.b}, p));
  // Under something higher neither is seen there, nor does it hide the other.
  if (scan_.is_above(p.x(), p.y(), own + snap_)) return;
  double z = own;
  if (double highest = 0; top(p, highest)) z = std::fmax(z, highest);
  const std::uint32_t made = add_point({p.x(), p.y(), z});
  f.stops.emplace_back(s, made);
  g.stops.emplace_back(t, made);
}

void LayerJoiner::cut_lines() {
  std::vector<PlanBox> boxes;
  for (const Line& line : lines_) boxes.push_back(box_of({line.a, line.b}, snap_));
  const PlanBins bins(boxes);
  std::vector<std::uint32_t> met;
  for (std::uint32_t i = 0; i < lines_.size(); ++i) {
    met.clear();
    bins.over(boxes[i], [&](std::uint32_t j) {
      if (j > i) met.push_back(j);
    });
    std::sort(met.begin(), met.end());
    met.erase(std::unique(met.begin(), met.end()), met.end());
    for (const std::uint32_t j : met) cut_pair(i, j);
  }
}

// Of a line, from one point of it to another.
bool LayerJoiner::is_seen(const Line& line, const Vec2& from, const Vec2& to) const {
  const Vec2 p = 0.5 * (from + to);
  double z = 0;
  // (At the scan's border there may be nothing, by rounding.)
  return !top(p, z) || z <= height_on({line.a, line.b}, p) + snap_;
}

void LayerJoiner::collect_pieces() {
  const auto add = [&](std::uint32_t a, std::uint32_t b) {
    pieces_.push_back({a, b});
    pieces_.push_back({b, a});
  };
  for (const Line& line : lines_) {
    if (line.fixed) add(line.a, line.b);
  }
  fixed_pieces_ = pieces_.size();
  for (Line& line : lines_) {
    if (line.fixed) continue;
    std::sort(line.stops.begin(), line.stops.end());
    std::uint32_t from = line.a;
    for (std::size_t k = 0; k <= line.stops.size(); ++k) {
      const std::uint32_t to = k == line.stops.size() ? line.b : line.stops[k].second;
      if (to == from) continue;
      if (is_seen(line, plan(from), plan(to))) add(from, to);
      from = to;
    }
  }
}

}  // namespace diesink
