// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/region_mesher.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/tessellate/unfold.h"

namespace diesink {
namespace {

// Of the chart's own spacing, which is for triangles that are regular: those of refinement are not
// quite.
constexpr double kSpacing = 0.93;
// Vertices inside a face that bends every way stand off it by this part of the tolerance, to the
// outside: triangles between them may then be as far beneath the face as they are above it, and
// take almost twice the area. Where the nearest vertex is less than 1 / kRoomy of the full spacing
// away, by less: as the square of that distance, like the gap beneath. Beside borders, whose
// vertices stay on the face, a part of the gain is left.
constexpr double kStandOff = 0.95, kRoomy = 1.5, kBorderShare = 0.15;
// Rounds of splitting chords that leave triangles too little of the tolerance.
constexpr int kTightRounds = 3;
// Rounds of splitting chords for triangles that look down.
constexpr int kTurnedRounds = 12;
// Rounds of halving a fan's chords: from the size of a part down to a tolerance.
constexpr int kFanRounds = 24;
// Vertices that a region laid in plan, or all but upright, may get: beside a silhouette its
// triangles are needles, and no number of them would do.
constexpr std::size_t kMostInPlan = 20'000;

}  // namespace

std::uint32_t RegionMesher::local(std::uint32_t arc_point) {
  const auto [it, fresh] =
      local_of_.try_emplace(arc_point, static_cast<std::uint32_t>(mesh_.position.size()));
  if (fresh) {
    mesh_.arc_point.push_back(arc_point);
    mesh_.position.push_back(samples_.at(arc_point, mesh_.label));
    mesh_.border_bound.push_back(0);
    points_.push_back(to_plane(mesh_.position.back()));
  }
  return it->second;
}

std::vector<RegionMesher::Chord> RegionMesher::build() {
  local_of_.clear();
  mesh_.arc_point.clear();
  mesh_.position.clear();
  mesh_.border_bound.clear();
  points_.clear();
  spacing_.clear();
  filter_.clear();
  off_face_.clear();
  broken_ = false;
  std::vector<PlanarTriangulation::Segment> segments;
  std::vector<std::uint32_t> chain;
  for (const std::vector<ArcUse>& loop : arrangement_.regions[mesh_.region].loops) {
    for (const ArcUse& use : loop) {
      samples_.chain(use.arc, chain);
      if (!use.forward) std::reverse(chain.begin(), chain.end());
      for (std::size_t k = 0; k + 1 < chain.size(); ++k) {
        const std::uint32_t a = local(chain[k]), b = local(chain[k + 1]);
        if (a == b) continue;
        const double d = samples_.chord_bound(chain[k], chain[k + 1]);
        mesh_.border_bound[a] = std::fmax(mesh_.border_bound[a], d);
        mesh_.border_bound[b] = std::fmax(mesh_.border_bound[b], d);
        segments.push_back({a, b});
      }
    }
  }
  draw_to_apex();
  triangulation_ = PlanarTriangulation();
  fan_.clear();
  aims_.clear();
  const bool was_strip = std::exchange(is_strip_, false);
  if (!in_plan_ &&
      (make_fan(segments) || ((was_strip || is_steep_side()) && make_strip(segments)))) {
    built_ = true;
    return {};
  }
  const std::vector<SegmentCrossing> wrong = triangulation_.build(points_, segments);
  built_ = wrong.empty();
  std::vector<Chord> split;
  const auto ask = [&](std::uint32_t segment) {
    if (segment < segments.size()) {
      split.push_back(
          {mesh_.arc_point[segments[segment][0]], mesh_.arc_point[segments[segment][1]]});
    }
  };
  for (const SegmentCrossing& w : wrong) {
    ask(w.segment_a);
    ask(w.segment_b);
  }
  // Between few long chords a region may be turned inside out, which names one of them alone.
  if (wrong.size() == 1 && wrong[0].segment_b == kNoSegment && wrong[0].point == kNoPoint) {
    split.clear();
    for (std::uint32_t s = 0; s < segments.size(); ++s) ask(s);
  }
  if (!built_) return split;
  if (!in_plan_ && may_be_strip_ && folds() && make_strip(segments)) return {};
  if (options_.grid_x != nullptr) {
    insert_grid();
  } else {
    insert_apex();
  }
  return {};
}

double RegionMesher::weight() const {
  double points = 0;
  for (const std::vector<ArcUse>& loop : arrangement_.regions[mesh_.region].loops) {
    for (const ArcUse& use : loop)
      points += static_cast<double>(samples_.arcs[use.arc].samples.size());
  }
  return chart_.is_plane() ? points : points * points;
}

// The vertex of the border that stands for the apex: the nearest of those as near as vertices of
// curves are held to.
std::optional<std::uint32_t> RegionMesher::border_vertex_at(const Vec3& apex) const {
  std::optional<std::uint32_t> nearest;
  double least = near_;
  for (std::uint32_t v = 0; v < mesh_.position.size(); ++v) {
    const double away = (mesh_.position[v] - apex).norm();
    if (away > least) continue;
    least = away;
    nearest = v;
  }
  return nearest;
}

// All rulings meet in the apex, where rounding would have a border that runs through it a hair
// aside: with the apex inside, once more, or with rulings of the border bent there.
void RegionMesher::draw_to_apex() {
  const std::optional<Vec3> apex = chart_.apex();
  if (!apex || in_plan_ || options_.grid_x != nullptr) return;
  if (const std::optional<std::uint32_t> v = border_vertex_at(*apex))
    points_[*v] = chart_.to_chart(*apex);
}

void RegionMesher::insert_apex() {
  const std::optional<Vec3> apex = chart_.apex();
  if (!apex || border_vertex_at(*apex)) return;
  const Vec2 c = to_plane(*apex);
  if (!triangulation_.insert(c)) return;
  mesh_.arc_point.push_back(ArcSamples::kNone);
  mesh_.position.push_back(*apex);
  mesh_.border_bound.push_back(0);
}

// The nodes of the grid inside the region; those that lie close beside an arc have moved onto it.
void RegionMesher::insert_grid() {
  const std::vector<double>&xs = *options_.grid_x, &ys = *options_.grid_y;
  PlanBox box{1e300, -1e300, 1e300, -1e300};
  for (const Vec2& p : points_) {
    box = {std::fmin(box.x0, p.x()), std::fmax(box.x1, p.x()), std::fmin(box.y0, p.y()),
           std::fmax(box.y1, p.y())};
  }
  const auto first = [](const std::vector<double>& v, double at) {
    return static_cast<std::size_t>(std::lower_bound(v.begin(), v.end(), at) - v.begin());
  };
  const std::size_t i0 = first(xs, box.x0), i1 = std::min(xs.size(), first(xs, box.x1) + 1);
  const std::size_t j0 = first(ys, box.y0), j1 = std::min(ys.size(), first(ys, box.y1) + 1);
  if (i0 >= i1 || j0 >= j1) return;
  // Border points binned by grid cell, to keep nodes off them.
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> bins;
  const auto bin = [&](const Vec2& p) {
    return (static_cast<std::uint64_t>(first(xs, p.x())) << 32) | first(ys, p.y());
  };
  for (std::uint32_t k = 0; k < points_.size(); ++k) bins[bin(points_[k])].push_back(k);
  const Vec2 spacing(xs.size() > 1 ? xs[1] - xs[0] : 1, ys.size() > 1 ? ys[1] - ys[0] : 1);
  const double close = 0.3 * std::fmin(spacing.x(), spacing.y());
  for (std::size_t j = j0; j < j1; ++j) {
    for (std::size_t i = i0; i < i1; ++i) {
      const Vec2 p(xs[i], ys[j]);
      bool crowded = false;
      for (std::uint64_t a = 0; a < 2 && !crowded; ++a) {
        for (std::uint64_t b = 0; b < 2 && !crowded; ++b) {
          const auto it = bins.find(((static_cast<std::uint64_t>(i) + a) << 32) |
                                    (static_cast<std::uint64_t>(j) + b));
          if (it == bins.end()) continue;
          for (const std::uint32_t k : it->second)
            crowded = crowded || (points_[k] - p).norm() < close;
        }
      }
      Vec3 q(p.x(), p.y(), 0);
      if (crowded || !samples_.surface_height(mesh_.label, p.x(), p.y(), q.z()) ||
          !triangulation_.insert(p))
        continue;
      mesh_.arc_point.push_back(ArcSamples::kNone);
      mesh_.position.push_back(q);
      mesh_.border_bound.push_back(0);
    }
  }
}

std::vector<RegionMesher::Chord> RegionMesher::refine() {
  if (!built_ || options_.grid_x != nullptr) return {};
  if (!fan_.empty()) {
    std::vector<Chord> chords;
    if (turned_rounds_++ < kFanRounds) {
      for (const auto& [chord, turn] : aims_) chords.push_back(chord);
      if (chords.empty()) chords = chords_of_fan();
    }
    urgent_ = !chords.empty();
    if (chords.empty() && is_strip_ && strip_fails()) {
      may_be_strip_ = false;
      turned_rounds_ = 0;
      broken_ = true;  // built anew, and refined
    }
    return chords;
  }
  RefineRules rules;
  rules.min_angle = chart_.is_plane() ? options_.flat_angle : options_.min_angle;
  rules.shortest_edge = options_.shortest;
  rules.max_vertices = in_plan_ ? points_.size() + kMostInPlan : 50'000'000;
  // What folds there folds at any size: it is laid anew in the end (unfold.h).
  const bool steep = !in_plan_ && is_steep_side();
  if (steep) rules.max_vertices = points_.size() + kMostInPlan;
  rules.too_coarse = [this](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    return too_coarse(a, b, c);
  };
  rules.folded = [this, steep](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    return !steep && is_folded(a, b, c) && !(is_off_face(a) || is_off_face(b) || is_off_face(c));
  };
  // New vertices have none yet, those of build() and of splits neither.
  const auto add_spacing = [this](std::size_t v, double room) {
    spacing_.push_back(kSpacing * chart_.spacing(mesh_.position[v], room));
    filter_.add(mesh_.position[v]);
  };
  for (std::size_t v = spacing_.size(); v < mesh_.position.size(); ++v) {
    double room = options_.tolerance;
    if (chart_.bends_every_way()) {
      Vec3 p = mesh_.position[v];
      room += kBorderShare * chart_.stand_off(kStandOff, options_.tolerance, p);
    }
    add_spacing(v, room);
  }
  if (in_plan_) {
    rules.min_angle = options_.flat_angle;
  } else {
    rules.spacing = [this](std::uint32_t v) { return spacing_[v]; };
  }
  rules.closing = [this](std::uint32_t a, std::uint32_t b) { return closing(a, b); };
  rules.add_vertex = [this, &add_spacing](const Vec2& c, double nearest) {
    Vec3 p;
    if (in_plan_) {
      p.head<2>() = c;
      if (!samples_.surface_height(mesh_.label, c.x(), c.y(), p.z())) return false;
    } else if (!chart_.from_chart(c, p)) {
      return false;
    }
    double room = options_.tolerance;
    if (!in_plan_ && chart_.bends_every_way()) {
      const double full = kSpacing * chart_.spacing(p, (1 + kStandOff) * options_.tolerance);
      const double ratio = std::fmin(1, kRoomy * nearest / full);
      const double off = chart_.stand_off(kStandOff * ratio * ratio, options_.tolerance, p);
      // (By the bound: `off` is the way to the plane that touches the face there.)
      if (off > 0) most_off_ = std::fmax(most_off_, deviation_(mesh_.label, p, p, p));
      room += off;
    }
    mesh_.arc_point.push_back(ArcSamples::kNone);
    mesh_.position.push_back(p);
    mesh_.border_bound.push_back(0);
    add_spacing(mesh_.position.size() - 1, room);
    return true;
  };
  std::vector<Chord> chords;
  for (const PlanarTriangulation::Segment& s : triangulation_.refine(rules)) {
    chords.push_back({mesh_.arc_point[s[0]], mesh_.arc_point[s[1]]});
  }
  urgent_ = false;
  if (in_plan_) return chords;
  if (chords.empty() && turned_rounds_ < kTurnedRounds && !steep) {
    chords = chords_of_turned();
    urgent_ = !chords.empty();
    if (urgent_) ++turned_rounds_;
  }
  if (chords.empty() && tight_ && tight_rounds_ < kTightRounds) {
    chords = chords_of_tight();
    tight_ = !chords.empty();
    ++tight_rounds_;
  }
  return chords;
}

void RegionMesher::take_split(const Chord& chord, std::uint32_t point) {
  if (!built_ || broken_) return;
  const auto a = local_of_.find(chord[0]), b = local_of_.find(chord[1]);
  if (a == local_of_.end() || b == local_of_.end()) return;
  const Vec3 p = samples_.at(point, mesh_.label);
  if (!fan_.empty() || !triangulation_.split_segment(a->second, b->second, to_plane(p))) {
    broken_ = true;  // built anew with what the arcs have become
    return;
  }
  local_of_[point] = static_cast<std::uint32_t>(mesh_.position.size());
  mesh_.arc_point.push_back(point);
  mesh_.position.push_back(p);
  mesh_.border_bound.push_back(
      std::fmax(samples_.chord_bound(chord[0], point), samples_.chord_bound(point, chord[1])));
}

void RegionMesher::keep(const Chord& chord) {
  const auto a = local_of_.find(chord[0]), b = local_of_.find(chord[1]);
  if (fan_.empty() && a != local_of_.end() && b != local_of_.end())
    triangulation_.keep_segment(a->second, b->second);
}

// Lays a folded region anew in plan, where nothing folds; false, and as it was, where its chords
// cross there.
bool RegionMesher::finish_in_plan() {
  RegionMesh folded = mesh_;
  if (!lay_in_plan()) return false;
  if (!build().empty()) {
    mesh_ = std::move(folded);
    return false;
  }
  for (;;) {
    const std::vector<Chord> chords = refine();
    if (chords.empty()) break;
    for (const Chord& chord : chords) keep(chord);
  }
  mesh_.triangles = triangulation_.triangles();
  return true;
}

RegionMesh RegionMesher::finish() {
  if (fan_.empty()) {
    mesh_.triangles = triangulation_.triangles();
  } else {
    finish_fan();
  }
  if (tight_rounds_ > 0) renew_border_bounds();
  UnfoldRules rules;
  rules.tolerance = options_.tolerance * (1 + 1e-9);
  rules.is_wrong = [this](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    return looks_down(a, b, c) || has_no_area(a, b, c) || may_round_down(a, b, c);
  };
  rules.bound = [this](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    return bound_of(face_bound_of(a, b, c), a, b, c);
  };
  const auto is_wrong = [&](const auto& t) { return rules.is_wrong(t[0], t[1], t[2]); };
  const bool in_plan = fan_.empty() && options_.to_the_end &&
                       std::any_of(mesh_.triangles.begin(), mesh_.triangles.end(), is_wrong) &&
                       finish_in_plan();
  if (!in_plan && (fan_.empty() || is_strip_)) unfold(mesh_.position, rules, mesh_.triangles);
  for (const auto& t : mesh_.triangles) {
    const double known = std::fmin(mesh_.largest_deviation, options_.tolerance);
    if (known > 0 && std::max({t[0], t[1], t[2]}) < filter_.size() &&
        filter_.compare(t[0], t[1], t[2], mesh_.position, known) ==
            DeviationFilter::Side::kWithin &&
        border_keeps(t[0], t[1], t[2], known)) {
      continue;
    }
    const double d = bound_of(face_bound_of(t[0], t[1], t[2]), t[0], t[1], t[2]);
    if (d < 1e300) mesh_.largest_deviation = std::fmax(mesh_.largest_deviation, d);
    if (!(d <= options_.tolerance * (1 + 1e-9))) {
      const Vec3 &a = mesh_.position[t[0]], &b = mesh_.position[t[1]], &c = mesh_.position[t[2]];
      if (mesh_.unproven_area == 0) mesh_.unproven_place = (a + b + c) / 3;
      mesh_.unproven_area +=
          0.5 * std::fabs((b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x()));
    }
  }
  return std::move(mesh_);
}

}  // namespace diesink
