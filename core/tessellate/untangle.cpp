// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/untangle.h"

#include <algorithm>
#include <cmath>

#include "core/tessellate/untangler.h"

namespace diesink {
namespace {

constexpr double kGrowth = 16;  // of the grain

}  // namespace

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
  out_.grain = grain_;
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

std::optional<Arrangement> untangle(const CompoundSurface::Impl& surface,
                                    const Arrangement& arrangement, const ArcSamples& samples,
                                    double largest_coordinate, std::size_t most_crossings) {
  // A power of two, so that what is on the lattice stays there when it is moved.
  const double finest = std::fmax(2.5e-10 * surface.size, std::ldexp(largest_coordinate, -50));
  for (double grain = std::exp2(std::floor(std::log2(finest)));; grain *= kGrowth) {
    Untangler untangler(surface, arrangement, samples, grain, most_crossings);
    if (untangler.is_too_coarse()) return std::nullopt;
    if (untangler.lay()) return untangler.make();
  }
}

}  // namespace diesink
