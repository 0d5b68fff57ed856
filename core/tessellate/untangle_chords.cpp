// Chords on a lattice of grains, and their crossings done away with.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>

#include "core/tessellate/untangler.h"

namespace diesink {
namespace {

constexpr double kHot = 0.75;  // grains: no farther from a vertex a chord runs through its pixel
constexpr int kRounds = 32;    // of splitting what crosses, before the grain grows

// What the arrangement has dropped bounds nothing.
bool is_gone(const PlanArc& arc) {
  return !arc.border && arc.left == kNoLabel && arc.right == kNoLabel;
}

}  // namespace

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
    if (arc.border != border || is_gone(arc)) continue;
    samples_.chain(a, chain);
    for (const std::uint32_t p : chain) {
      const ArcPoint& at = samples_.points[p];
      std::uint32_t& v = vertex_of_[p];
      if (v == kNone) {
        Vec2 q(at.x, at.y);
        if (!border) {
          q = inside(q);
        } else if (!arc.fixed) {
          // A vertex of a scan may lie a hair inside of the border that runs along its edge.
          const std::array<double, 4> off{q.x() - box_.x0, box_.x1 - q.x(), q.y() - box_.y0,
                                          box_.y1 - q.y()};
          const auto side = std::ranges::min_element(off) - off.begin();
          if (off[static_cast<std::size_t>(side)] != 0) {
            if (side < 2) q.x() = side == 0 ? box_.x0 : box_.x1;
            if (side >= 2) q.y() = side == 2 ? box_.y0 : box_.y1;
          }
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
    if (is_gone(arc)) continue;
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
  if (wrong.size() > crossings_left_) {
    crossings_left_ = 0;
    return false;
  }
  crossings_left_ -= wrong.size();
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
  vertex_of_.assign(samples_.points.size(), kNone);
  take_points(true);
  take_points(false);
  take_chords();
  for (int round = 0; round < kRounds && crossings_left_ > 0; ++round) {
    if (build()) return true;
  }
  return false;
}

}  // namespace diesink
