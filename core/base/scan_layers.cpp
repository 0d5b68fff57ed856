// Lines that may be seen are cut where they pass over one another, the pieces that are seen are
// triangulated, and each triangle is a piece of what is seen at its middle, or of a strip.
// SPDX-License-Identifier: Apache-2.0
#include "core/base/scan_layers.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <unordered_map>

#include "core/base/exact_plan.h"
#include "core/mesh_tools/topology.h"
#include "core/mesh_tools/weld.h"
#include "core/pair_key.h"
#include "core/plan_bins.h"
#include "core/tessellate/planar_triangulation.h"

namespace diesink {
namespace {

constexpr std::uint32_t kNone = ScanSheet::kNone;
// Of the strips' width: how far the lower layer has to lie below a rim to need one.
constexpr double kLeastStep = 0.5;
// Of the strips' width: points that close are one.
constexpr double kSnap = 1e-3;
constexpr int kMostAttempts = 64;
// Of the way from an edge of a piece to its middle: where it is looked at.
constexpr double kBesideEdge = 1e-6;

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

class LayerJoiner {
 public:
  LayerJoiner(const ScannedSurface& scan, const std::vector<std::array<std::uint32_t, 3>>& faces,
              double lean, ScanSheet& sheet)
      : scan_(scan), faces_(faces), lean_(lean), snap_(kSnap * lean), sheet_(sheet) {}

  void run(int threads);

 private:
  enum class Part : std::uint8_t { kHidden, kWhole, kJoined };  // of a face
  struct Rim {
    std::uint32_t a, b;                            // the upper layer on the left
    std::uint32_t foot_a = kNone, foot_b = kNone;  // a and b themselves where there is no step
  };
  struct Line {
    std::uint32_t a, b;
    bool fixed = false;         // side of a face that stays whole
    bool foot = false;          // its height is that of what it runs over
    std::uint32_t rim = kNone;  // of a foot line: its rim
    std::vector<std::pair<double, std::uint32_t>> stops;
  };

  [[nodiscard]] Vec2 plan(std::uint32_t v) const { return sheet_.points[v].head<2>(); }
  [[nodiscard]] PlanBox box_of(std::initializer_list<std::uint32_t> vertices, double more) const;
  static std::uint64_t key(std::uint32_t a, std::uint32_t b) {
    return pair_key(std::min(a, b), std::max(a, b));
  }
  [[nodiscard]] bool top(const Vec2& p, double& z) const {
    BaseHit hit;
    if (!scan_.at(p.x(), p.y(), hit)) return false;
    z = hit.z;
    return true;
  }
  std::uint32_t add_point(const Vec3& p) {
    sheet_.points.push_back(p);
    at_wall_.push_back(0);
    return static_cast<std::uint32_t>(sheet_.points.size() - 1);
  }

  void find_rims();
  void place_feet();
  void choose_faces(const std::vector<char>& marks);
  void add_lines(const std::vector<std::array<Vec3, 2>>& meets);
  void cut_lines();
  void cut_pair(std::uint32_t i, std::uint32_t j);
  [[nodiscard]] bool in_strip(const Rim& rim, const Vec2& p, bool strictly) const;
  [[nodiscard]] double height_on(const Rim& rim, const Vec2& p) const;  // over its line
  [[nodiscard]] bool behind_strip(const Vec2& p, double z, std::uint32_t but) const;
  [[nodiscard]] bool is_seen(const Line& line, const Vec2& from, const Vec2& to) const;
  void collect_pieces();
  void triangulate();
  void take_cell(const std::array<std::uint32_t, 3>& v, bool all_lines);

  const ScannedSurface& scan_;
  const std::vector<std::array<std::uint32_t, 3>>& faces_;
  double lean_, snap_;
  ScanSheet& sheet_;
  std::vector<Part> part_;
  std::vector<Rim> rims_;
  std::vector<PlanBox> strip_boxes_;
  std::optional<PlanBins> strips_;
  std::vector<Line> lines_;
  std::vector<char> at_wall_;                         // points on rims and their feet
  std::vector<PlanarTriangulation::Segment> pieces_;  // each both ways
  std::size_t fixed_pieces_ = 0;                      // those first
};

PlanBox LayerJoiner::box_of(std::initializer_list<std::uint32_t> vertices, double more) const {
  PlanBox box{HUGE_VAL, -HUGE_VAL, HUGE_VAL, -HUGE_VAL};
  for (const std::uint32_t v : vertices) {
    const Vec3& p = sheet_.points[v];
    box = {std::fmin(box.x0, p.x() - more), std::fmax(box.x1, p.x() + more),
           std::fmin(box.y0, p.y() - more), std::fmax(box.y1, p.y() + more)};
  }
  return box;
}

// Edges with faces on one side alone in plan, beyond which something lies lower.
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
        lower = lower || z < height_on(rim, m) - kLeastStep * lean_;
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

// One foot a rim's vertex, outside, on whatever lies there.
void LayerJoiner::place_feet() {
  std::unordered_map<std::uint32_t, Vec2> outward;
  std::vector<std::uint32_t> order;
  for (const Rim& rim : rims_) {
    const Vec2 d = (plan(rim.b) - plan(rim.a)).normalized();
    for (const std::uint32_t v : {rim.a, rim.b}) {
      const auto [it, fresh] = outward.try_emplace(v, Vec2::Zero());
      if (fresh) order.push_back(v);
      it->second += Vec2(d.y(), -d.x());
    }
  }
  std::unordered_map<std::uint32_t, std::uint32_t> foot;
  for (const std::uint32_t v : order) {
    at_wall_[v] = 1;
    foot[v] = v;
    const Vec2 d = outward[v];
    if (!(d.norm() > 1e-6)) continue;
    const Vec3 p = sheet_.points[v];
    // Straight on, or aside where the scan ends there.
    for (const double turned : {0.0, 0.6, -0.6, 1.2, -1.2, 1.5, -1.5}) {
      const Vec2 u = d.normalized();
      const Vec2 q =
          p.head<2>() + lean_ * Vec2(std::cos(turned) * u.x() - std::sin(turned) * u.y(),
                                     std::sin(turned) * u.x() + std::cos(turned) * u.y());
      double z = 0;
      if (!top(q, z)) continue;
      if (std::fabs(z - p.z()) <= kLeastStep * lean_) break;
      foot[v] = add_point({q.x(), q.y(), z});
      at_wall_[foot[v]] = 1;
      break;
    }
  }
  for (Rim& rim : rims_) {
    rim.foot_a = foot[rim.a];
    rim.foot_b = foot[rim.b];
    strip_boxes_.push_back(box_of({rim.a, rim.b, rim.foot_a, rim.foot_b}, 0));
  }
  strips_.emplace(strip_boxes_);
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
  std::vector<std::uint32_t> over;
  for (const Rim& rim : rims_) {
    const std::uint32_t corner[4] = {rim.a, rim.foot_a, rim.foot_b, rim.b};
    scan_.faces_over(box_of({rim.a, rim.b, rim.foot_a, rim.foot_b}, snap_), over);
    for (const std::uint32_t f : over) {
      const auto& t = faces_[f];
      if (t[0] == kNone || part_[f] == Part::kJoined) continue;
      // Apart where a side of the face, or of the strip, has all of the other beyond it.
      bool apart = false;
      const double room = part_[f] == Part::kWhole ? snap_ : -snap_;
      for (std::size_t k = 0; k < 3 && !apart; ++k) {
        const Vec2 from = plan(t[k]), along = (plan(t[(k + 1) % 3]) - from).normalized();
        apart = true;
        for (const std::uint32_t c : corner) apart = apart && cross(along, plan(c) - from) <= room;
      }
      for (std::size_t k = 0; k < 4 && !apart; ++k) {
        const Vec2 from = plan(corner[k]), along = plan(corner[(k + 1) % 4]) - from;
        const double length = along.norm();
        if (!(length > snap_)) continue;
        apart = true;
        for (const std::uint32_t v : t)
          apart = apart && cross(along, plan(v) - from) <= room * length;
      }
      if (!apart) part_[f] = Part::kJoined;
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
  for (std::uint32_t r = 0; r < rims_.size(); ++r) {
    const Rim& rim = rims_[r];
    if (rim.foot_a == rim.a && rim.foot_b == rim.b) continue;
    Line line;
    line.a = rim.foot_a;
    line.b = rim.foot_b;
    line.foot = true;
    line.rim = r;
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
    const double own = line.foot ? sheet_.points[end].z() : height_on({line.a, line.b}, plan(end));
    std::uint32_t stop = end;
    if (std::fabs(own - sheet_.points[end].z()) > snap_) {
      stop = add_point({plan(end).x(), plan(end).y(), own});
      at_wall_[stop] = at_wall_[end];
    }
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
  double own = -HUGE_VAL;  // of what is no foot
  for (const Line* line : {&f, &g}) {
    if (line->foot) continue;
    const double at = line == &f ? s : t;
    const double za = sheet_.points[line->a].z(), zb = sheet_.points[line->b].z();
    own = std::fmax(own, za + at * (zb - za));
  }
  // Under something higher neither is seen there, nor does it hide the other, and a foot runs on
  // over it.
  if (!(f.foot && g.foot) && scan_.is_above(p.x(), p.y(), own + snap_)) return;
  double z = own;
  if (double highest = 0; top(p, highest)) z = std::fmax(z, highest);
  if (!(z > -HUGE_VAL)) return;
  const std::uint32_t made = add_point({p.x(), p.y(), z});
  if (f.foot || g.foot) at_wall_[made] = 1;
  for (const Line* line : {&f, &g}) {
    if (!line->foot && at_wall_[line->a] && at_wall_[line->b]) at_wall_[made] = 1;
  }
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

bool LayerJoiner::in_strip(const Rim& rim, const Vec2& p, bool strictly) const {
  const std::uint32_t corner[4] = {rim.a, rim.foot_a, rim.foot_b, rim.b};
  if (rim.foot_a == rim.a && rim.foot_b == rim.b) return false;
  for (std::size_t k = 0; k < 4; ++k) {
    if (corner[k] == corner[(k + 1) % 4]) continue;
    const Vec2 from = plan(corner[k]), along = plan(corner[(k + 1) % 4]) - from;
    if (!(cross(along, p - from) >= (strictly ? snap_ : 0) * along.norm())) return false;
  }
  return true;
}

// Whether p, at the height z, lies where a strip of a higher rim stands.
bool LayerJoiner::behind_strip(const Vec2& p, double z, std::uint32_t but) const {
  bool behind = false;
  strips_->over({p.x(), p.x(), p.y(), p.y()}, [&](std::uint32_t r) {
    if (r == but || behind) return;
    behind = in_strip(rims_[r], p, true) && height_on(rims_[r], p) > z + kLeastStep * lean_;
  });
  return behind;
}

// Of a line, from one point of it to another.
bool LayerJoiner::is_seen(const Line& line, const Vec2& from, const Vec2& to) const {
  const Vec2 p = 0.5 * (from + to);
  double z = 0;
  if (!top(p, z)) return false;
  if (line.foot) {
    const double rim = height_on(rims_[line.rim], p);
    return z < rim - kLeastStep * lean_ && !behind_strip(p, z, line.rim);
  }
  const double own = height_on({line.a, line.b}, p);
  return z <= own + snap_ && !behind_strip(p, own, kNone);
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
      if (is_seen(line, plan(from), plan(to))) {
        add(from, to);
        if (line.foot) sheet_.moved = 2 * lean_;
      }
      from = to;
    }
  }
}

void LayerJoiner::triangulate() {
  // Points at one place are one: a whole face's, else the topmost. A frame round all keeps what is
  // open out.
  std::vector<std::uint32_t> used;
  for (const auto& s : pieces_) used.insert(used.end(), s.begin(), s.end());
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  std::vector<char> fixed(sheet_.points.size(), 0);
  for (const Line& line : lines_) {
    if (line.fixed) fixed[line.a] = fixed[line.b] = 1;
  }
  std::sort(used.begin(), used.end(), [&](std::uint32_t i, std::uint32_t j) {
    if (fixed[i] != fixed[j]) return fixed[i] > fixed[j];
    const double zi = sheet_.points[i].z(), zj = sheet_.points[j].z();
    return zi != zj ? zi > zj : i < j;
  });
  std::vector<Vec3> flat;
  for (const std::uint32_t v : used) flat.emplace_back(plan(v).x(), plan(v).y(), 0);
  const WeldMap weld = weld_map(flat, snap_);
  std::vector<Vec2> sites;
  std::vector<std::uint32_t> vertex;
  for (const std::uint32_t k : weld.kept) {
    sites.push_back(plan(used[k]));
    vertex.push_back(used[k]);
  }
  std::unordered_map<std::uint32_t, std::uint32_t> site;
  for (std::size_t k = 0; k < used.size(); ++k) {
    site[used[k]] = weld.of_vertex[k];
    if (at_wall_[used[k]]) at_wall_[vertex[weld.of_vertex[k]]] = 1;
  }
  PlanBox box{HUGE_VAL, -HUGE_VAL, HUGE_VAL, -HUGE_VAL};
  for (const Vec2& p : sites) {
    box = {std::fmin(box.x0, p.x()), std::fmax(box.x1, p.x()), std::fmin(box.y0, p.y()),
           std::fmax(box.y1, p.y())};
  }
  const double margin = 0.1 * (box.x1 - box.x0 + box.y1 - box.y0) + 64 * lean_;
  const auto frame = static_cast<std::uint32_t>(sites.size());
  for (const auto& [x, y] : {std::pair{box.x0 - margin, box.y0 - margin},
                             {box.x1 + margin, box.y0 - margin},
                             {box.x1 + margin, box.y1 + margin},
                             {box.x0 - margin, box.y1 + margin}}) {
    sites.emplace_back(x, y);
    vertex.push_back(kNone);
  }
  std::vector<PlanarTriangulation::Segment> segments;
  for (std::uint32_t k = 0; k < 4; ++k) segments.push_back({frame + k, frame + (k + 1) % 4});
  std::unordered_map<std::uint64_t, char> known;  // directed
  std::size_t fixed_segments = segments.size();
  for (std::size_t s = 0; s < pieces_.size(); ++s) {
    const std::uint32_t a = site[pieces_[s][0]], b = site[pieces_[s][1]];
    if (a == b || !known.try_emplace(pair_key(a, b), 0).second) continue;
    segments.push_back({a, b});
    if (s < fixed_pieces_) fixed_segments = segments.size();
  }
  bool all_lines = true;
  for (int attempt = 0; attempt < kMostAttempts; ++attempt) {
    // Only what lines still use.
    std::vector<std::uint32_t> number(sites.size(), kNone), of;
    std::vector<Vec2> points;
    std::vector<PlanarTriangulation::Segment> numbered;
    for (const auto& s : segments) {
      for (const std::uint32_t v : s) {
        if (number[v] != kNone) continue;
        number[v] = static_cast<std::uint32_t>(points.size());
        points.push_back(sites[v]);
        of.push_back(v);
      }
      numbered.push_back({number[s[0]], number[s[1]]});
    }
    PlanarTriangulation triangulation;
    std::vector<SegmentCrossing> wrong = triangulation.build(points, numbered);
    for (SegmentCrossing& w : wrong) {
      for (std::uint32_t* q : {&w.point, &w.other_point}) *q = *q < of.size() ? of[*q] : kNone;
    }
    if (wrong.empty()) {
      for (const auto& t : triangulation.triangles()) {
        const std::array<std::uint32_t, 3> v{vertex[of[t[0]]], vertex[of[t[1]]], vertex[of[t[2]]]};
        if (v[0] != kNone && v[1] != kNone && v[2] != kNone) take_cell(v, all_lines);
      }
      return;
    }
    // Lines that still pass over one another, or over a point, by rounding: cut there, or else the
    // later one gives way. Sides of whole faces come first and stay.
    std::unordered_map<std::uint64_t, std::uint32_t> cut;  // by the ends: the site, or kNone
    for (const SegmentCrossing& w : wrong) {
      std::uint32_t s = w.segment_a, other = w.segment_b;
      if (other < segments.size() && (s >= segments.size() || other > s)) std::swap(s, other);
      if (s >= segments.size()) continue;
      if (s < fixed_segments) {  // nothing may lie on it
        for (const auto& q : std::span(segments).subspan(fixed_segments)) {
          const bool there =
              q[0] == w.point || q[1] == w.point || q[0] == w.other_point || q[1] == w.other_point;
          if (there) cut[key(q[0], q[1])] = kNone;
        }
        continue;
      }
      const auto [a, b] = segments[s];
      std::uint32_t at = w.point != a && w.point != b ? w.point : kNone;
      if (at == kNone && other < segments.size() && other >= fixed_segments) {
        const auto [c, d] = segments[other];
        const Vec2 u = sites[b] - sites[a], v = sites[d] - sites[c];
        const Vec2 p = sites[a] + cross(sites[c] - sites[a], v) / cross(u, v) * u;
        double z = 0;
        const bool near_end = std::min({(p - sites[a]).norm(), (p - sites[b]).norm(),
                                        (p - sites[c]).norm(), (p - sites[d]).norm()}) <= snap_;
        if (!near_end && top(p, z) && cut.count(key(c, d)) == 0) {
          at = static_cast<std::uint32_t>(sites.size());
          sites.push_back(p);
          vertex.push_back(add_point({p.x(), p.y(), z}));
          if (at_wall_[vertex[a]] && at_wall_[vertex[b]]) at_wall_.back() = 1;
          if (at_wall_[vertex[c]] && at_wall_[vertex[d]]) at_wall_.back() = 1;
          cut[key(c, d)] = at;
        }
      }
      cut[key(a, b)] = at;
    }
    if (cut.empty()) break;
    std::vector<PlanarTriangulation::Segment> rest;
    for (const auto& s : segments) {
      const auto it = cut.find(key(s[0], s[1]));
      if (it == cut.end()) {
        rest.push_back(s);
      } else if (it->second == kNone) {
        all_lines = false;
      } else {
        for (const auto& [from, to] : {std::pair{s[0], it->second}, std::pair{it->second, s[1]}}) {
          if (known.try_emplace(pair_key(from, to), 0).second) rest.push_back({from, to});
        }
      }
    }
    segments = std::move(rest);
  }
  // Left open: a hole, counted.
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    if (part_[f] != Part::kJoined) continue;
    const Vec3 &a = sheet_.points[faces_[f][0]], &b = sheet_.points[faces_[f][1]],
               &c = sheet_.points[faces_[f][2]];
    sheet_.unproven_area += 0.5 * cross((b - a).head<2>(), (c - a).head<2>());
  }
}

void LayerJoiner::take_cell(const std::array<std::uint32_t, 3>& v, bool all_lines) {
  const Vec3 &a = sheet_.points[v[0]], &b = sheet_.points[v[1]], &c = sheet_.points[v[2]];
  const Vec3 m = (a + b + c) / 3;
  const Vec2 p = m.head<2>();
  BaseHit hit;
  if (!scan_.at(p.x(), p.y(), hit)) return;
  const double area = 0.5 * cross((b - a).head<2>(), (c - a).head<2>());
  if (behind_strip(p, hit.z, kNone)) {
    sheet_.triangles.push_back(v);
    // As thin as the strip, between its rim and its foot.
    const double longest = std::fmax((b - a).head<2>().norm(),
                                     std::fmax((c - b).head<2>().norm(), (a - c).head<2>().norm()));
    const bool walls = at_wall_[v[0]] && at_wall_[v[1]] && at_wall_[v[2]];
    if (!walls || !(2 * area <= 1.5 * lean_ * longest)) sheet_.unproven_area += area;
    return;
  }
  if (part_[hit.face] != Part::kJoined) return;
  sheet_.triangles.push_back(v);
  const auto off = [&](const Vec3& q) {
    return std::fabs(hit.z + hit.zx * (q.x() - m.x()) + hit.zy * (q.y() - m.y()) - q.z());
  };
  bool proven = off(a) <= lean_ && off(b) <= lean_ && off(c) <= lean_;
  // Without some of the lines it may be more than one piece. (Looked at beside its edges: on one at
  // the border of the scan the scan is there or not by rounding.)
  for (const Vec3& edge : {Vec3(0.5 * (a + b)), Vec3(0.5 * (b + c)), Vec3(0.5 * (c + a))}) {
    const Vec3 q = edge + kBesideEdge * (m - edge);
    double z = 0;
    if (!all_lines) proven = proven && top(q.head<2>(), z) && std::fabs(z - q.z()) <= lean_;
  }
  if (!proven) sheet_.unproven_area += area;
}

void LayerJoiner::run(int threads) {
  const ScannedSurface::Layers layers = scan_.layers(threads);
  at_wall_.assign(sheet_.points.size(), 0);
  find_rims();
  place_feet();
  choose_faces(layers.marks);
  bool joined = false;
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    if (part_[f] == Part::kWhole) sheet_.triangles.push_back(faces_[f]);
    joined = joined || part_[f] == Part::kJoined;
  }
  if (!joined) return;
  add_lines(layers.meets);
  cut_lines();
  collect_pieces();
  triangulate();
}

}  // namespace

void join_layers(const ScannedSurface& scan, const std::vector<std::array<std::uint32_t, 3>>& faces,
                 double lean, int threads, ScanSheet& sheet) {
  LayerJoiner(scan, faces, lean, sheet).run(threads);
}

}  // namespace diesink
