// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/untangle.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <unordered_map>
#include <utility>

#include "core/pair_key.h"
#include "core/tessellate/planar_triangulation.h"

namespace diesink {
namespace {

using Impl = CompoundSurface::Impl;
using Ends = std::pair<std::uint32_t, std::uint32_t>;

constexpr std::uint32_t kNone = 0xFFFFFFFFu;
constexpr double kHot = 0.75;    // grains: no farther from a vertex a chord runs through its pixel
constexpr int kRounds = 32;      // of splitting what crosses, before the grain grows
constexpr double kGrowth = 16;   // of the grain
constexpr double kWidest = 0.1;  // grain, of the domain's shorter side
constexpr std::size_t kMostEvaluated = 64;  // triangles of a face that are asked for its label

// What an arc says of a chord: labels on either side, from its lower vertex to its higher one.
struct Claim {
  Label left = kNoLabel, right = kNoLabel;
};

struct Chord {
  std::vector<Claim> claims;
  double bound = 0;
  std::uint8_t side = 4;  // on the border of the domain: 0 bottom, 1 right, 2 top, 3 left
  bool seam = false;
};

class Untangler {
 public:
  Untangler(const Impl& surface, const Arrangement& from, const ArcSamples& samples, double grain)
      : surface_(surface),
        from_(from),
        samples_(samples),
        solver_(surface),
        box_(from.box),
        grain_(grain) {}

  // The chords, and their crossings done away with; false where that does not end.
  bool lay();
  Arrangement make();

 private:
  struct Face {  // of the triangulation: what no chord parts
    std::vector<std::uint32_t> triangles;
  };

  [[nodiscard]] double snapped(double v) const { return grain_ * std::nearbyint(v / grain_); }
  [[nodiscard]] Vec2 inside(const Vec2& p) const;
  std::uint32_t vertex(const Vec2& p);
  void take_points(bool border);
  void take_chords();
  void join(std::uint32_t u, std::uint32_t v, const Chord& chord);
  bool build();
  void fill_buckets();
  [[nodiscard]] std::size_t bucket_of(double at, double low, double high) const;
  void take_near(const Ends& ends, std::vector<std::uint32_t>& near) const;
  void split(const std::map<Ends, std::vector<std::uint32_t>>& at);

  [[nodiscard]] std::uint32_t across(std::uint32_t u, std::uint32_t v) const {
    const auto found = left_of_.find(pair_key(v, u));
    return found == left_of_.end() ? kNone : found->second;
  }
  [[nodiscard]] const Chord* chord_between(std::uint32_t u, std::uint32_t v) const {
    const auto found = chords_.find(std::minmax(u, v));
    return found == chords_.end() ? nullptr : &found->second;
  }
  [[nodiscard]] Vec2 middle(std::uint32_t t) const;
  [[nodiscard]] double area(std::uint32_t t) const;
  [[nodiscard]] Label label_at(std::uint32_t t) const;
  void label_faces();
  void label_face(const Face& face);
  void tell(const Vec2& place, double doubtful);

  [[nodiscard]] bool parts(std::uint32_t u, std::uint32_t v) const;
  void make_nodes();
  double height(std::uint32_t v, Label label) const;
  void make_arcs();
  void walk(std::uint32_t from, std::uint32_t to);
  void make_regions();

  const Impl& surface_;
  const Arrangement& from_;
  const ArcSamples& samples_;
  CurveSolver solver_;
  PlanBox box_;
  double grain_;
  bool no_holes_ = false;
  std::vector<Vec2> points_;
  std::vector<std::vector<LabelHeight>> heights_;  // that arcs know, of each vertex
  std::vector<char> on_border_, on_seam_;
  std::map<std::pair<double, double>, std::uint32_t> vertex_at_;
  std::vector<std::uint32_t> vertex_of_;  // of each arc point
  std::map<Ends, Chord> chords_;          // by their vertices, the lower number first
  int buckets_ = 1;                       // of vertices, so many along either axis
  std::vector<std::vector<std::uint32_t>> bucket_;
  PlanarTriangulation triangulation_;
  std::vector<PlanarTriangulation::Corners> triangles_;
  std::unordered_map<std::uint64_t, std::uint32_t> left_of_;  // the triangle to the left of a side
  std::vector<Label> label_;                                  // of each triangle
  std::vector<std::vector<std::uint32_t>> neighbours_;  // of each vertex, over sides that part
  std::unordered_map<std::uint64_t, ArcUse> use_of_;    // of each such side, directed
  Arrangement out_;
};

// A place on the lattice of grains, off the border by one at the least.
Vec2 Untangler::inside(const Vec2& p) const {
  return {std::clamp(snapped(p.x()), box_.x0 + grain_, box_.x1 - grain_),
          std::clamp(snapped(p.y()), box_.y0 + grain_, box_.y1 - grain_)};
}

std::uint32_t Untangler::vertex(const Vec2& p) {
  const auto [it, fresh] =
      vertex_at_.try_emplace({p.x(), p.y()}, static_cast<std::uint32_t>(points_.size()));
  if (fresh) {
    points_.push_back(p);
    heights_.emplace_back();
    on_border_.push_back(0);
    on_seam_.push_back(0);
  }
  return it->second;
}

// The vertices of arc points: those of border arcs, which stay on the border, before all others.
void Untangler::take_points(bool border) {
  std::vector<std::uint32_t> chain;
  for (std::uint32_t a = 0; a < from_.arcs.size(); ++a) {
    const PlanArc& arc = from_.arcs[a];
    if (arc.border != border) continue;
    samples_.chain(a, chain);
    for (const std::uint32_t p : chain) {
      const ArcPoint& at = samples_.points[p];
      std::uint32_t& v = vertex_of_[p];
      if (v == kNone) {
        Vec2 q(at.x, at.y);
        if (!border) {
          q = inside(q);
        } else if (!arc.fixed) {
          if (q.x() != box_.x0 && q.x() != box_.x1)
            q.x() = std::clamp(snapped(q.x()), box_.x0 + grain_, box_.x1 - grain_);
          if (q.y() != box_.y0 && q.y() != box_.y1)
            q.y() = std::clamp(snapped(q.y()), box_.y0 + grain_, box_.y1 - grain_);
        }
        v = vertex(q);
        if (border) on_border_[v] = 1;
        if (at.node != ArcPoint::kNoNode && from_.nodes[at.node].seam) on_seam_[v] = 1;
      }
      std::vector<LabelHeight>& known = heights_[v];
      const auto learn = [&](const LabelHeight& h) {
        if (h.label == kNoLabel ||
            std::ranges::any_of(known, [&](const LabelHeight& k) { return k.label == h.label; }))
          return;
        known.push_back(h);
      };
      if (at.node != ArcPoint::kNoNode) std::ranges::for_each(from_.nodes[at.node].heights, learn);
      for (const Label label : {arc.left, arc.right}) {
        if (label != kNoLabel) learn({label, samples_.z(p, label)});
      }
    }
  }
}

void Untangler::join(std::uint32_t u, std::uint32_t v, const Chord& chord) {
  if (u == v) return;
  Chord& own = chords_[std::minmax(u, v)];
  for (const Claim& c : chord.claims) own.claims.push_back(u < v ? c : Claim{c.right, c.left});
  own.bound = std::fmax(own.bound, chord.bound);
  if (chord.side < 4) own.side = chord.side;
  own.seam = own.seam || chord.seam;
}

void Untangler::take_chords() {
  std::vector<std::uint32_t> chain;
  for (std::uint32_t a = 0; a < from_.arcs.size(); ++a) {
    const PlanArc& arc = from_.arcs[a];
    samples_.chain(a, chain);
    for (std::size_t k = 0; k + 1 < chain.size(); ++k) {
      const std::uint32_t u = vertex_of_[chain[k]], v = vertex_of_[chain[k + 1]];
      Chord chord;
      chord.claims.push_back({arc.left, arc.border ? arc.left : arc.right});
      chord.bound = samples_.chord_bound(chain[k], chain[k + 1]) + (arc.fixed ? 0 : 2 * grain_);
      chord.seam = arc.border && arc.fixed;
      if (arc.border) {
        const Vec2 &p = points_[u], &q = points_[v];
        chord.side = static_cast<std::uint8_t>(p.y() == q.y()     ? (p.y() == box_.y0 ? 0 : 2)
                                               : p.x() == box_.x1 ? 1
                                                                  : 3);
      }
      join(u, v, chord);
    }
  }
}

void Untangler::split(const std::map<Ends, std::vector<std::uint32_t>>& at) {
  for (const auto& [ends, vertices] : at) {
    const auto [u, v] = ends;
    const Chord chord = chords_.at(ends);
    const Vec2 p = points_[u], d = points_[v] - p;
    std::vector<std::pair<double, std::uint32_t>> order;
    for (const std::uint32_t w : vertices) order.emplace_back((points_[w] - p).dot(d), w);
    std::ranges::sort(order);
    chords_.erase(ends);
    std::uint32_t last = u;
    for (const auto& [t, w] : order) {
      if (w == last || w == v) continue;
      // What a label's height is on the chord, in case its surface does not reach the vertex.
      for (const LabelHeight& h0 : heights_[u]) {
        for (const LabelHeight& h1 : heights_[v]) {
          double z = 0;
          if (h0.label != h1.label || solver_.height(h0.label, points_[w].x(), points_[w].y(), z) ||
              std::ranges::any_of(heights_[w],
                                  [&](const LabelHeight& h) { return h.label == h0.label; }))
            continue;
          const double s = std::clamp(t / d.squaredNorm(), 0.0, 1.0);
          heights_[w].push_back({h0.label, h0.z + s * (h1.z - h0.z)});
        }
      }
      join(last, w, chord);
      last = w;
    }
    join(last, v, chord);
  }
}

void Untangler::fill_buckets() {
  buckets_ = std::max(1, static_cast<int>(std::sqrt(static_cast<double>(points_.size()))));
  bucket_.assign(static_cast<std::size_t>(buckets_) * static_cast<std::size_t>(buckets_), {});
  for (std::uint32_t v = 0; v < points_.size(); ++v)
    bucket_[bucket_of(points_[v].y(), box_.y0, box_.y1) * static_cast<std::size_t>(buckets_) +
            bucket_of(points_[v].x(), box_.x0, box_.x1)]
        .push_back(v);
}

std::size_t Untangler::bucket_of(double at, double low, double high) const {
  const double n = buckets_;
  return static_cast<std::size_t>(
      std::clamp(std::floor(n * (at - low) / (high - low)), 0.0, n - 1));
}

// The vertices that a chord runs through, to the grain. Without them pieces of chords side by side
// would cross anew wherever rounding moves one of them.
void Untangler::take_near(const Ends& ends, std::vector<std::uint32_t>& near) const {
  const Vec2 p = points_[ends.first], d = points_[ends.second] - p;
  const double reach = kHot * grain_, length2 = d.squaredNorm();
  const double low = std::fmin(p.y(), p.y() + d.y()) - reach;
  const double high = std::fmax(p.y(), p.y() + d.y()) + reach;
  const double tall = (box_.y1 - box_.y0) / buckets_;
  const std::size_t last = bucket_of(high, box_.y0, box_.y1);
  for (std::size_t row = bucket_of(low, box_.y0, box_.y1); row <= last; ++row) {
    // The part of the chord in the row.
    double t0 = 0, t1 = 1;
    if (d.y() != 0) {
      const double y = box_.y0 + static_cast<double>(row) * tall;
      const double a = (y - 2 * reach - p.y()) / d.y(), b = (y + tall + 2 * reach - p.y()) / d.y();
      t0 = std::clamp(std::fmin(a, b), 0.0, 1.0);
      t1 = std::clamp(std::fmax(a, b), 0.0, 1.0);
    }
    const double x0 = p.x() + t0 * d.x(), x1 = p.x() + t1 * d.x();
    const std::size_t end = bucket_of(std::fmax(x0, x1) + 2 * reach, box_.x0, box_.x1);
    for (std::size_t column = bucket_of(std::fmin(x0, x1) - 2 * reach, box_.x0, box_.x1);
         column <= end; ++column) {
      for (const std::uint32_t v : bucket_[row * static_cast<std::size_t>(buckets_) + column]) {
        const Vec2 q = points_[v] - p;
        const double along = q.dot(d);
        if (v != ends.first && v != ends.second && along > 0 && along < length2 &&
            std::fabs(q.x() * d.y() - q.y() * d.x()) <= reach * std::sqrt(length2))
          near.push_back(v);
      }
    }
  }
}

// Triangulates; false, and what crosses split, where that does not go.
bool Untangler::build() {
  std::vector<PlanarTriangulation::Segment> segments;
  std::vector<Ends> of;
  for (const auto& [ends, chord] : chords_) {
    const auto [u, v] = ends;
    if (chord.side < 4) {  // the domain on the left
      const Vec2 d = points_[v] - points_[u];
      const bool ahead = chord.side == 0   ? d.x() > 0
                         : chord.side == 1 ? d.y() > 0
                         : chord.side == 2 ? d.x() < 0
                                           : d.y() < 0;
      segments.push_back(ahead ? PlanarTriangulation::Segment{u, v}
                               : PlanarTriangulation::Segment{v, u});
      of.push_back(ends);
      continue;
    }
    segments.push_back({u, v});
    segments.push_back({v, u});
    of.insert(of.end(), 2, ends);
  }
  triangulation_ = PlanarTriangulation();
  const std::vector<SegmentCrossing> wrong = triangulation_.build(points_, segments);
  if (wrong.empty()) return true;
  std::map<Ends, std::vector<std::uint32_t>> at;
  const auto cut = [&](std::uint32_t segment, std::uint32_t w) {
    const Ends& ends = of[segment];
    if (w == ends.first || w == ends.second || chords_.at(ends).seam) return;
    at[ends].push_back(w);
  };
  for (const SegmentCrossing& w : wrong) {
    if (w.segment_a >= of.size()) continue;
    for (const std::uint32_t s : {w.segment_a, w.segment_b}) {
      if (s < of.size() && !chords_.at(of[s]).seam) at[of[s]];
    }
    if (w.point != kNoPoint) cut(w.segment_a, w.point);
    if (w.segment_b >= of.size() || of[w.segment_a] == of[w.segment_b]) continue;
    const auto [a, b] = of[w.segment_a];
    const auto [c, d] = of[w.segment_b];
    const Vec2 u = points_[b] - points_[a], v = points_[d] - points_[c],
               gap = points_[c] - points_[a];
    const double cross = u.x() * v.y() - u.y() * v.x();
    if (cross == 0) continue;
    const double t = std::clamp((gap.x() * v.y() - gap.y() * v.x()) / cross, 0.0, 1.0);
    const std::uint32_t x = vertex(inside(points_[a] + t * u));
    cut(w.segment_a, x);
    cut(w.segment_b, x);
  }
  fill_buckets();
  for (auto& [ends, vertices] : at) {
    if (chords_.at(ends).side == 4) take_near(ends, vertices);
  }
  split(at);
  return false;
}

bool Untangler::lay() {
  if (!(grain_ <= kWidest * std::fmin(box_.x1 - box_.x0, box_.y1 - box_.y0))) return false;
  vertex_of_.assign(samples_.points.size(), kNone);
  take_points(true);
  take_points(false);
  take_chords();
  for (int round = 0; round < kRounds; ++round) {
    if (build()) return true;
  }
  return false;
}

Vec2 Untangler::middle(std::uint32_t t) const {
  const auto& c = triangles_[t];
  return (points_[c[0]] + points_[c[1]] + points_[c[2]]) / 3;
}

double Untangler::area(std::uint32_t t) const {
  const auto& c = triangles_[t];
  const Vec2 u = points_[c[1]] - points_[c[0]], v = points_[c[2]] - points_[c[0]];
  return 0.5 * (u.x() * v.y() - u.y() * v.x());
}

Label Untangler::label_at(std::uint32_t t) const {
  const Vec2 p = middle(t);
  return surface_.evaluate_face(p.x(), p.y()).label;
}

void Untangler::tell(const Vec2& place, double doubtful) {
  if (!(doubtful > 0)) return;
  if (out_.uncertified_area == 0) out_.uncertified_place = place;
  out_.uncertified_area += doubtful;
}

void Untangler::label_face(const Face& face) {
  struct Said {
    std::uint32_t triangle, u, v;
    Label label;
    bool seam;
  };
  std::vector<Said> said;
  for (const std::uint32_t t : face.triangles) {
    const auto& c = triangles_[t];
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t u = c[k], v = c[(k + 1) % 3];
      const Chord* chord = chord_between(u, v);
      if (chord == nullptr) continue;
      for (const Claim& claim : chord->claims)
        said.push_back({t, u, v, u < v ? claim.left : claim.right, chord->seam});
    }
  }
  const auto agree = [&](const Said& s) { return s.label == said.front().label; };
  if (!said.empty() && std::ranges::all_of(said, agree)) {
    for (const std::uint32_t t : face.triangles) label_[t] = said.front().label;
    return;
  }
  std::vector<std::uint32_t> asked = face.triangles;
  std::ranges::stable_sort(asked,
                           [&](std::uint32_t a, std::uint32_t b) { return area(a) > area(b); });
  if (asked.size() > kMostEvaluated) asked.resize(kMostEvaluated);
  std::map<Label, double> found;  // what evaluation finds, and over how much
  for (const std::uint32_t t : asked) found[label_at(t)] += area(t);
  if (no_holes_) {
    found.erase(kNoLabel);
    for (const Said& s : said) {
      if (s.label != kNoLabel) found.try_emplace(s.label, 0.0);
    }
  }
  Label best = found.empty() ? kNoLabel : found.begin()->first;
  for (const auto& [label, share] : found) {
    if (share > found[best]) best = label;
  }
  // The other side of a cut between tiles has been made already, or will be, with the cut's labels.
  const auto first = std::ranges::find_if(said, [](const Said& s) { return s.seam; });
  bool one_by_one = false;
  if (first != said.end()) {
    best = first->label;
    one_by_one =
        std::ranges::any_of(said, [&](const Said& s) { return s.seam && s.label != best; });
  }
  for (const std::uint32_t t : face.triangles) label_[t] = one_by_one ? label_at(t) : best;
  for (const Said& s : said) {
    if (one_by_one && s.seam) label_[s.triangle] = s.label;
  }
  // What is not as its chords have it, or not as it is where it was asked; a chord that is wrong
  // tells of a square beside it.
  double whole = 0, doubtful = one_by_one ? HUGE_VAL : 0;
  for (const std::uint32_t t : face.triangles) whole += area(t);
  for (const auto& [label, share] : found) doubtful += label != best ? share : 0;
  const Said* wrong = nullptr;
  for (const Said& s : said) {
    if (s.label == best) continue;
    if (wrong == nullptr) wrong = &s;
    doubtful += (points_[s.v] - points_[s.u]).squaredNorm();
  }
  tell(wrong != nullptr ? Vec2(0.5 * (points_[wrong->u] + points_[wrong->v]))
                        : middle(face.triangles.front()),
       std::fmin(whole, doubtful));
}

void Untangler::label_faces() {
  triangles_ = triangulation_.triangles();
  for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
    const auto& c = triangles_[t];
    for (std::size_t k = 0; k < 3; ++k) left_of_[pair_key(c[k], c[(k + 1) % 3])] = t;
  }
  label_.assign(triangles_.size(), kNoLabel);
  std::vector<char> known(triangles_.size(), 0);
  for (std::uint32_t first = 0; first < triangles_.size(); ++first) {
    if (known[first]) continue;
    Face face;
    face.triangles.push_back(first);
    known[first] = 1;
    for (std::size_t k = 0; k < face.triangles.size(); ++k) {
      const auto& c = triangles_[face.triangles[k]];
      for (std::size_t e = 0; e < 3; ++e) {
        const std::uint32_t u = c[e], v = c[(e + 1) % 3], other = across(u, v);
        if (other == kNone || known[other] || chord_between(u, v) != nullptr) continue;
        known[other] = 1;
        face.triangles.push_back(other);
      }
    }
    label_face(face);
  }
}

// Whether the sides of u-v have two labels, or it is on the border.
bool Untangler::parts(std::uint32_t u, std::uint32_t v) const {
  const auto one = left_of_.find(pair_key(u, v));
  const std::uint32_t other = across(u, v);
  return one == left_of_.end() || other == kNone || label_[one->second] != label_[other];
}

double Untangler::height(std::uint32_t v, Label label) const {
  for (const LabelHeight& h : heights_[v]) {
    if (h.label == label) return h.z;
  }
  const Vec2& p = points_[v];
  double z = 0;
  if (solver_.height(label, p.x(), p.y(), z) || solver_.silhouette_height(label, p.x(), p.y(), z))
    return z;
  // A face that does not come so far: as high as the nearest vertex that knows it.
  double nearest = HUGE_VAL;
  for (std::uint32_t w = 0; w < points_.size(); ++w) {
    const double far = (points_[w] - p).squaredNorm();
    for (const LabelHeight& h : heights_[w]) {
      if (h.label != label || !(far < nearest)) continue;
      nearest = far;
      z = h.z;
    }
  }
  return nearest < HUGE_VAL ? z : surface_.evaluate_face(p.x(), p.y()).z;
}

void Untangler::make_nodes() {
  neighbours_.resize(points_.size());
  std::vector<std::vector<Label>> around(points_.size());
  for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
    const auto& c = triangles_[t];
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t u = c[k], v = c[(k + 1) % 3];
      if (label_[t] != kNoLabel && std::ranges::find(around[u], label_[t]) == around[u].end())
        around[u].push_back(label_[t]);
      const bool border = across(u, v) == kNone;
      if (!parts(u, v) || (!border && u > v)) continue;
      neighbours_[u].push_back(v);
      neighbours_[v].push_back(u);
    }
  }
  for (std::uint32_t v = 0; v < points_.size(); ++v) {
    PlanNode node;
    node.x = points_[v].x();
    node.y = points_[v].y();
    node.border = on_border_[v] != 0;
    node.seam = on_seam_[v] != 0;
    const bool corner =
        (node.x == box_.x0 || node.x == box_.x1) && (node.y == box_.y0 || node.y == box_.y1);
    node.kept = neighbours_[v].size() == 2 && !corner;
    node.corner = !node.kept;
    if (!neighbours_[v].empty()) {
      for (const Label label : around[v]) node.heights.push_back({label, height(v, label)});
      if (!node.seam) join_heights(node.heights, 1e-9 * surface_.size);
    }
    out_.nodes.push_back(std::move(node));
  }
}

// The arc that begins with a side.
void Untangler::walk(std::uint32_t from, std::uint32_t to) {
  PlanArc arc;
  const auto id = static_cast<std::uint32_t>(out_.arcs.size());
  const auto left = left_of_.find(pair_key(from, to)), right = left_of_.find(pair_key(to, from));
  arc.border = right == left_of_.end();
  arc.left = label_[left->second];
  if (!arc.border) arc.right = label_[right->second];
  arc.fixed = true;
  arc.nodes.push_back(from);
  std::uint32_t u = from, v = to;
  for (;;) {
    arc.nodes.push_back(v);
    arc.curves.emplace_back();
    const Chord* chord = chord_between(u, v);
    arc.bounds.push_back(chord != nullptr ? chord->bound : 0);
    use_of_[pair_key(u, v)] = {id, true};
    if (!arc.border) use_of_[pair_key(v, u)] = {id, false};
    if (out_.nodes[v].corner) break;
    if (v == from) {
      arc.closed = true;
      break;
    }
    const std::uint32_t next = neighbours_[v][neighbours_[v][0] == u ? 1 : 0];
    u = v;
    v = next;
  }
  out_.arcs.push_back(std::move(arc));
}

void Untangler::make_arcs() {
  // From corners first; what is left is closed.
  for (const bool corners : {true, false}) {
    for (std::uint32_t u = 0; u < points_.size(); ++u) {
      if (out_.nodes[u].corner != corners) continue;
      for (const std::uint32_t v : neighbours_[u]) {
        // Of the border the way that has the domain on its left.
        if (left_of_.contains(pair_key(u, v)) && !use_of_.contains(pair_key(u, v))) walk(u, v);
      }
    }
  }
}

void Untangler::make_regions() {
  std::vector<std::uint32_t> region_of(triangles_.size(), kNone);
  std::uint32_t count = 0;
  for (std::uint32_t first = 0; first < triangles_.size(); ++first) {
    if (region_of[first] != kNone) continue;
    std::vector<std::uint32_t> open{first};
    region_of[first] = count;
    while (!open.empty()) {
      const auto c = triangles_[open.back()];
      open.pop_back();
      for (std::size_t e = 0; e < 3; ++e) {
        const std::uint32_t u = c[e], v = c[(e + 1) % 3];
        if (parts(u, v) || region_of[across(u, v)] != kNone) continue;
        region_of[across(u, v)] = count;
        open.push_back(across(u, v));
      }
    }
    PlanRegion region;
    region.label = label_[first];
    out_.regions.push_back(std::move(region));
    ++count;
  }
  // Loops, each from the side it begins with; the side after one is found round their vertex.
  std::vector<std::vector<double>> areas(count);
  std::vector<char> used(2 * out_.arcs.size(), 0);
  const auto third = [&](std::uint32_t t, std::uint32_t u, std::uint32_t v) {
    for (const std::uint32_t w : triangles_[t]) {
      if (w != u && w != v) return w;
    }
    return kNone;
  };
  for (std::uint32_t a = 0; a < out_.arcs.size(); ++a) {
    for (const bool forward : {true, false}) {
      if ((out_.arcs[a].border && !forward) || used[2 * a + (forward ? 0 : 1)]) continue;
      std::vector<ArcUse> loop;
      double twice = 0;
      std::uint32_t region = kNone;
      for (ArcUse use{a, forward}; !used[2 * use.arc + (use.forward ? 0 : 1)];) {
        used[2 * use.arc + (use.forward ? 0 : 1)] = 1;
        loop.push_back(use);
        std::vector<std::uint32_t> nodes = out_.arcs[use.arc].nodes;
        if (!use.forward) std::ranges::reverse(nodes);
        const Vec2 o = points_[out_.arcs[a].nodes.front()];
        for (std::size_t k = 0; k + 1 < nodes.size(); ++k) {
          const Vec2 p = points_[nodes[k]] - o, q = points_[nodes[k + 1]] - o;
          twice += p.x() * q.y() - p.y() * q.x();
        }
        std::uint32_t u = nodes[nodes.size() - 2];
        const std::uint32_t v = nodes.back();
        std::uint32_t t = left_of_.at(pair_key(u, v));
        region = region_of[t];
        if (out_.arcs[use.arc].closed) break;
        for (;;) {
          const std::uint32_t w = third(t, u, v);
          if (parts(v, w)) {
            use = use_of_.at(pair_key(v, w));
            break;
          }
          t = across(v, w);
          u = w;
        }
      }
      out_.regions[region].loops.push_back(std::move(loop));
      areas[region].push_back(twice);
    }
  }
  for (std::uint32_t r = 0; r < count; ++r) {  // the outer one first
    const auto outer = std::ranges::max_element(areas[r]) - areas[r].begin();
    std::swap(out_.regions[r].loops.front(),
              out_.regions[r].loops[static_cast<std::size_t>(outer)]);
  }
}

Arrangement Untangler::make() {
  out_.box = box_;
  out_.cells = from_.cells;
  out_.least_cells = from_.least_cells;
  out_.uncertified_area = from_.uncertified_area;
  out_.uncertified_place = from_.uncertified_place;
  if (samples_.unproven_length > 0) {  // what the chords' bounds did not show
    const ArcPoint& p = samples_.points[samples_.unproven_point];
    tell({p.x, p.y}, 2 * samples_.largest_deviation * samples_.unproven_length);
  }
  label_faces();
  if (std::ranges::all_of(label_, [](Label l) { return l == kNoLabel; })) {
    // Somewhere there is a surface, though not where it was looked for.
    no_holes_ = true;
    label_faces();
  }
  make_nodes();
  make_arcs();
  make_regions();
  return std::move(out_);
}

}  // namespace

std::optional<Arrangement> untangle(const Impl& surface, const Arrangement& arrangement,
                                    const ArcSamples& samples, double largest_coordinate) {
  // A power of two, so that what is on the lattice stays there when it is moved.
  const double finest = std::fmax(2.5e-10 * surface.size, std::ldexp(largest_coordinate, -50));
  for (double grain = std::exp2(std::floor(std::log2(finest)));; grain *= kGrowth) {
    const PlanBox& box = arrangement.box;
    if (!(grain <= kWidest * std::fmin(box.x1 - box.x0, box.y1 - box.y0))) return std::nullopt;
    Untangler untangler(surface, arrangement, samples, grain);
    if (untangler.lay()) return untangler.make();
  }
}

}  // namespace diesink
