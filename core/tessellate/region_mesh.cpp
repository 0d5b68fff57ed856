// Rounds: every region refines by itself, then the arcs that any of them wants split are split for
// both sides. Source: Ruppert, "A Delaunay refinement algorithm for quality 2-dimensional mesh
// generation", 1995, with the segments shared by independent triangulations.
// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/region_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include "core/parallel.h"
#include "core/tessellate/deviation_filter.h"
#include "core/tessellate/unfold.h"

namespace diesink {
namespace {

using Impl = CompoundSurface::Impl;

// Share of the tolerance that triangles are refined to whatever their arcs leave of it.
constexpr double kLeastRoom = 0.3;
// Of the chart's own spacing, which is for triangles that are regular: those of refinement are not
// quite.
constexpr double kSpacing = 0.93;
// Rounds of splitting chords that leave triangles too little of the tolerance.
constexpr int kTightRounds = 3;
// Slopes between triangle and face up to which what lies near a chord can be told apart.
constexpr double kGentle = 0.5;
// Chords of one region's border that cross, over all rounds: more are of borders that overlap.
constexpr std::size_t kMostCrossings = 20'000;
// Rounds of splitting chords for triangles that look down.
constexpr int kTurnedRounds = 12;

class Region {
 public:
  Region(const Impl& surface, const Arrangement& arrangement, const ArcSamples& samples,
         const TriangleDeviation& deviation, const RegionOptions& options, std::uint32_t index)
      : arrangement_(arrangement),
        samples_(samples),
        deviation_(deviation),
        options_(options),
        chart_(surface, arrangement.regions[index].label, deviation.base()),
        filter_(deviation, arrangement.regions[index].label),
        flat_(2 * options.least_altitude) {
    mesh_.label = arrangement.regions[index].label;
    mesh_.region = index;
  }

  using Chord = std::array<std::uint32_t, 2>;  // arc points

  // Builds anew from the arcs as they are; the chords to split where that does not go.
  std::vector<Chord> build();
  // One round; the chords to split before it can go on.
  std::vector<Chord> refine();
  // A chord of this region's border has got a point in its middle.
  void take_split(const Chord& chord, std::uint32_t point);
  void keep(const Chord& chord);
  [[nodiscard]] bool broken() const { return broken_; }
  // What refine() asked for last must be split however short it is.
  [[nodiscard]] bool urgent() const { return urgent_; }
  RegionMesh finish();
  // Triangles to be expected, roughly: curved faces are filled at the spacing of their borders.
  [[nodiscard]] double weight() const;

 private:
  [[nodiscard]] Vec2 to_plane(const Vec3& p) const {
    return options_.grid_x != nullptr ? Vec2(p.head<2>()) : chart_.to_chart(p);
  }
  std::uint32_t local(std::uint32_t arc_point);
  std::vector<Chord> chords_of_turned();
  std::vector<Chord> chords_of_tight();
  void renew_border_bounds();
  void insert_apex();
  void insert_grid();
  [[nodiscard]] bool closing(std::uint32_t a, std::uint32_t b) const;
  [[nodiscard]] bool looks_down(std::uint32_t a, std::uint32_t b, std::uint32_t c) const;
  [[nodiscard]] bool may_round_down(std::uint32_t a, std::uint32_t b, std::uint32_t c) const;
  [[nodiscard]] bool has_no_area(std::uint32_t a, std::uint32_t b, std::uint32_t c) const;
  [[nodiscard]] double longest_edge(std::uint32_t a, std::uint32_t b, std::uint32_t c) const;
  // Distance between the triangle and its face, that of its vertices' chords from their arcs, and
  // both.
  [[nodiscard]] double face_bound_of(std::uint32_t a, std::uint32_t b, std::uint32_t c) const;
  [[nodiscard]] double border_bound_of(std::uint32_t a, std::uint32_t b, std::uint32_t c) const;
  [[nodiscard]] double bound_of(double face, std::uint32_t a, std::uint32_t b,
                                std::uint32_t c) const;
  // True where bound_of() is at most the limit if the face's bound is.
  [[nodiscard]] bool border_keeps(std::uint32_t a, std::uint32_t b, std::uint32_t c,
                                  double limit) const;
  [[nodiscard]] bool too_coarse(std::uint32_t a, std::uint32_t b, std::uint32_t c) const;

  const Arrangement& arrangement_;
  const ArcSamples& samples_;
  const TriangleDeviation& deviation_;
  const RegionOptions& options_;
  FaceChart chart_;
  DeviationFilter filter_;
  double flat_;  // altitude of a triangle without area
  PlanarTriangulation triangulation_;
  RegionMesh mesh_;
  std::unordered_map<std::uint32_t, std::uint32_t> local_of_;
  std::vector<Vec2> points_;
  std::vector<double> spacing_;                           // of each vertex, chart length
  std::unordered_map<std::uint32_t, Chord> worst_chord_;  // of those that end at a vertex
  bool built_ = false, broken_ = false, urgent_ = false;
  mutable bool tight_ = false;  // arcs leave some triangle no room
  int turned_rounds_ = 0, tight_rounds_ = 0;
};

std::uint32_t Region::local(std::uint32_t arc_point) {
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

std::vector<Region::Chord> Region::build() {
  local_of_.clear();
  mesh_.arc_point.clear();
  mesh_.position.clear();
  mesh_.border_bound.clear();
  points_.clear();
  spacing_.clear();
  filter_.clear();
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
  triangulation_ = PlanarTriangulation();
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
  if (!built_) return split;
  if (options_.grid_x != nullptr) {
    insert_grid();
  } else {
    insert_apex();
  }
  return {};
}

double Region::weight() const {
  double points = 0;
  for (const std::vector<ArcUse>& loop : arrangement_.regions[mesh_.region].loops) {
    for (const ArcUse& use : loop)
      points += static_cast<double>(samples_.arcs[use.arc].samples.size());
  }
  return chart_.is_plane() ? points : points * points;
}

void Region::insert_apex() {
  const std::optional<Vec3> apex = chart_.apex();
  if (!apex) return;
  const Vec2 c = chart_.to_chart(*apex);
  if (!triangulation_.insert(c)) return;
  mesh_.arc_point.push_back(ArcSamples::kNone);
  mesh_.position.push_back(*apex);
  mesh_.border_bound.push_back(0);
}

// The nodes of the grid inside the region; those that lie close beside an arc have moved onto it.
void Region::insert_grid() {
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

// Two vertices on arcs that end at one corner, nearer to each other than the least angle would have
// them so far from it.
bool Region::closing(std::uint32_t a, std::uint32_t b) const {
  const std::uint32_t pa = mesh_.arc_point[a], pb = mesh_.arc_point[b];
  if (pa == ArcSamples::kNone || pb == ArcSamples::kNone) return false;
  const std::uint32_t arc_a = samples_.points[pa].arc, arc_b = samples_.points[pb].arc;
  if (arc_a == arc_b || arc_a == ArcPoint::kNoNode || arc_b == ArcPoint::kNoNode) return false;
  const double gap = (mesh_.position[a] - mesh_.position[b]).norm();
  const auto ends = [&](std::uint32_t arc) {
    const PlanArc& of = arrangement_.arcs[arc];
    return std::array<std::uint32_t, 2>{of.nodes.front(), of.nodes.back()};
  };
  for (const std::uint32_t na : ends(arc_a)) {
    const PlanNode& corner = arrangement_.nodes[na];
    for (const std::uint32_t nb : ends(arc_b)) {
      const PlanNode& other = arrangement_.nodes[nb];
      // Corners that are not told apart at the tolerance are one.
      if (na != nb && std::hypot(corner.x - other.x, corner.y - other.y) > options_.shortest)
        continue;
      const Vec3& at = mesh_.position[a];
      if (gap < 0.4 * std::hypot(at.x() - corner.x, at.y() - corner.y)) return true;
    }
  }
  return false;
}

double Region::longest_edge(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
  return std::fmax((mesh_.position[a] - mesh_.position[b]).norm(),
                   std::fmax((mesh_.position[b] - mesh_.position[c]).norm(),
                             (mesh_.position[c] - mesh_.position[a]).norm()));
}

double Region::border_bound_of(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
  return std::fmax(mesh_.border_bound[a], std::fmax(mesh_.border_bound[b], mesh_.border_bound[c]));
}

double Region::face_bound_of(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
  // No point of a triangle is farther from its vertices, which lie on the surface, than its longest
  // edge over the square root of three; that bounds the smallest where no better bound holds (at an
  // apex).
  return std::fmin(deviation_(mesh_.label, mesh_.position[a], mesh_.position[b], mesh_.position[c]),
                   0.58 * longest_edge(a, b, c));
}

// A point p of the triangle has its foot on the surface within the face's bound f, along the
// triangle's normal. Where that foot lies beyond an arc, p lies between the arc's chord and the arc
// as seen along the normal: with d the way from the chord to the arc beside p, and s <= d·e the
// distance of p from the chord along e, in the triangle and across the chord, p is
// |d - s e|² = d² - s (2 d·e - s) from the arc, so no farther than the chord is. The larger of both
// is the bound, not their sum. The factor of two before d·e is room for neighbouring triangles,
// whose normals differ from that of the one at the chord: `slope` bounds by how much, as a gap that
// is quadratic, at most f and nothing at the vertices falls off by at most 8 f / altitude.
double Region::bound_of(double face, std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
  const double border = border_bound_of(a, b, c);
  if (border == 0 || face == 0) return face + border;
  const Vec3 &p = mesh_.position[a], &q = mesh_.position[b], &r = mesh_.position[c];
  const double altitude = (q - p).cross(r - p).norm() / longest_edge(a, b, c);
  const double slope = 8 * face / altitude;
  return slope < kGentle ? std::fmax(face, border) : face + border;
}

bool Region::border_keeps(std::uint32_t a, std::uint32_t b, std::uint32_t c, double limit) const {
  const double border = border_bound_of(a, b, c);
  if (border == 0) return true;
  if (border > limit) return false;
  const Vec3 &p = mesh_.position[a], &q = mesh_.position[b], &r = mesh_.position[c];
  const double square =
      std::max({(q - p).squaredNorm(), (r - q).squaredNorm(), (p - r).squaredNorm()});
  // As in bound_of(), with the limit in place of the face's bound.
  const double steepest = 0.999 * kGentle / (8 * limit);
  return square < steepest * steepest * (q - p).cross(r - p).squaredNorm();
}

bool Region::too_coarse(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
  const double tolerance = options_.tolerance;
  const DeviationFilter::Side side = filter_.compare(a, b, c, mesh_.position, tolerance);
  if (side == DeviationFilter::Side::kWithin && border_keeps(a, b, c, tolerance)) return false;
  // Next to nothing across: only its arcs could mend it.
  const double longest = longest_edge(a, b, c);
  if (!(longest > 0.25 * tolerance)) return false;
  if (side == DeviationFilter::Side::kBeyond && 0.57 * longest > tolerance) return true;
  // What arcs leave no room for, vertices inside cannot mend.
  const double face = face_bound_of(a, b, c);
  if (bound_of(face, a, b, c) <= tolerance) return false;
  if (face > kLeastRoom * tolerance) return true;
  tight_ = true;
  return false;
}

// By more than rounding turns an upright triangle.
bool Region::looks_down(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
  const Vec3 u = mesh_.position[b] - mesh_.position[a], v = mesh_.position[c] - mesh_.position[a];
  const Vec3 n = u.cross(v);
  return n.z() < 0 && n.z() < -1e-9 * n.norm();
}

// Nearer to upright than the rounding of vertices that are moved afterwards may turn it.
bool Region::may_round_down(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
  if (options_.largest_coordinate == 0) return false;
  const double ulp = std::ldexp(options_.largest_coordinate, -52);
  const Vec3 u = mesh_.position[b] - mesh_.position[a], v = mesh_.position[c] - mesh_.position[a];
  return u.x() * v.y() - u.y() * v.x() <
         2 * ulp * (u.head<2>().lpNorm<1>() + v.head<2>().lpNorm<1>());
}

bool Region::has_no_area(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
  const Vec3 &p = mesh_.position[a], &q = mesh_.position[b], &r = mesh_.position[c];
  return !((q - p).cross(r - p).norm() > flat_ * longest_edge(a, b, c));
}

std::vector<Region::Chord> Region::refine() {
  if (!built_ || options_.grid_x != nullptr) return {};
  RefineRules rules;
  rules.min_angle = chart_.is_plane() ? options_.flat_angle : options_.min_angle;
  rules.shortest_edge = options_.shortest;
  rules.max_vertices = 50'000'000;
  rules.too_coarse = [this](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    return too_coarse(a, b, c);
  };
  rules.folded = [this](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    return looks_down(a, b, c) && longest_edge(a, b, c) > 0.25 * options_.tolerance;
  };
  // New vertices have none yet, those of build() and of splits neither.
  const auto add_spacing = [this](std::size_t v) {
    spacing_.push_back(kSpacing * chart_.spacing(mesh_.position[v], options_.tolerance));
    filter_.add(mesh_.position[v]);
  };
  for (std::size_t v = spacing_.size(); v < mesh_.position.size(); ++v) add_spacing(v);
  rules.spacing = [this](std::uint32_t v) { return spacing_[v]; };
  rules.closing = [this](std::uint32_t a, std::uint32_t b) { return closing(a, b); };
  rules.add_vertex = [this, &add_spacing](const Vec2& c) {
    Vec3 p;
    if (!chart_.from_chart(c, p)) return false;
    mesh_.arc_point.push_back(ArcSamples::kNone);
    mesh_.position.push_back(p);
    mesh_.border_bound.push_back(0);
    add_spacing(mesh_.position.size() - 1);
    return true;
  };
  std::vector<Chord> chords;
  for (const PlanarTriangulation::Segment& s : triangulation_.refine(rules)) {
    chords.push_back({mesh_.arc_point[s[0]], mesh_.arc_point[s[1]]});
  }
  urgent_ = false;
  if (chords.empty() && turned_rounds_ < kTurnedRounds) {
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

// The bounds of chords as they are now: splits have left those of their ends as they were.
void Region::renew_border_bounds() {
  worst_chord_.clear();
  std::fill(mesh_.border_bound.begin(), mesh_.border_bound.end(), 0);
  std::vector<std::uint32_t> chain;
  for (const std::vector<ArcUse>& loop : arrangement_.regions[mesh_.region].loops) {
    for (const ArcUse& use : loop) {
      samples_.chain(use.arc, chain);
      for (std::size_t k = 0; k + 1 < chain.size(); ++k) {
        const double d = samples_.chord_bound(chain[k], chain[k + 1]);
        for (const std::uint32_t p : {chain[k], chain[k + 1]}) {
          const auto own = local_of_.find(p);
          if (own == local_of_.end()) continue;
          double& most = mesh_.border_bound[own->second];
          if (d > most) worst_chord_[own->second] = {chain[k], chain[k + 1]};
          most = std::fmax(most, d);
        }
      }
    }
  }
}

// In the narrow end between two arcs a triangle's own bound and that of its chords add up: chords
// that leave it too little room are split.
std::vector<Region::Chord> Region::chords_of_tight() {
  renew_border_bounds();
  std::vector<Chord> chords;
  for (const auto& t : triangulation_.triangles()) {
    if (border_bound_of(t[0], t[1], t[2]) == 0 ||
        bound_of(face_bound_of(t[0], t[1], t[2]), t[0], t[1], t[2]) <= options_.tolerance)
      continue;
    std::uint32_t worst = t[0];
    for (const std::uint32_t v : t) {
      if (mesh_.border_bound[v] > mesh_.border_bound[worst]) worst = v;
    }
    const auto chord = worst_chord_.find(worst);
    if (chord != worst_chord_.end()) chords.push_back(chord->second);
  }
  std::sort(chords.begin(), chords.end());
  chords.erase(std::unique(chords.begin(), chords.end()), chords.end());
  return chords;
}

// Beside a silhouette chords of two arcs that never meet may cross in plan, one above the other:
// the triangles between them look down. Shorter chords do not.
std::vector<Region::Chord> Region::chords_of_turned() {
  std::vector<Chord> chords;
  for (const auto& t : triangulation_.triangles()) {
    if (!looks_down(t[0], t[1], t[2])) continue;
    // The longest alone: where two arcs leave a corner in one direction short chords of the one
    // cross long ones of the other for ever, however short.
    Chord longest{};
    double length = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t u = t[k], v = t[(k + 1) % 3];
      const std::uint32_t p = mesh_.arc_point[u], q = mesh_.arc_point[v];
      if (p == ArcSamples::kNone || q == ArcSamples::kNone || !samples_.is_chord(p, q)) continue;
      const double own = (mesh_.position[u] - mesh_.position[v]).norm();
      if (!(own > length)) continue;
      length = own;
      longest = {p, q};
    }
    if (length > 0) chords.push_back(longest);
  }
  return chords;
}

void Region::take_split(const Chord& chord, std::uint32_t point) {
  if (!built_ || broken_) return;
  const auto a = local_of_.find(chord[0]), b = local_of_.find(chord[1]);
  if (a == local_of_.end() || b == local_of_.end()) return;
  const Vec3 p = samples_.at(point, mesh_.label);
  if (!triangulation_.split_segment(a->second, b->second, to_plane(p))) {
    broken_ = true;  // built anew with what the arcs have become
    return;
  }
  local_of_[point] = static_cast<std::uint32_t>(mesh_.position.size());
  mesh_.arc_point.push_back(point);
  mesh_.position.push_back(p);
  mesh_.border_bound.push_back(
      std::fmax(samples_.chord_bound(chord[0], point), samples_.chord_bound(point, chord[1])));
}

void Region::keep(const Chord& chord) {
  const auto a = local_of_.find(chord[0]), b = local_of_.find(chord[1]);
  if (a != local_of_.end() && b != local_of_.end())
    triangulation_.keep_segment(a->second, b->second);
}

RegionMesh Region::finish() {
  mesh_.triangles = triangulation_.triangles();
  if (tight_rounds_ > 0) renew_border_bounds();
  UnfoldRules rules;
  rules.tolerance = options_.tolerance * (1 + 1e-9);
  rules.is_wrong = [this](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    return looks_down(a, b, c) || has_no_area(a, b, c) || may_round_down(a, b, c);
  };
  rules.bound = [this](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    return bound_of(face_bound_of(a, b, c), a, b, c);
  };
  unfold(mesh_.position, rules, mesh_.triangles);
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

}  // namespace

Result<std::vector<RegionMesh>> mesh_regions(const Impl& surface, const Arrangement& arrangement,
                                             ArcSamples& samples, const RegionOptions& options) {
  const TriangleDeviation deviation(surface);
  std::vector<std::unique_ptr<Region>> regions;
  std::vector<std::uint32_t> region_of;
  for (std::uint32_t k = 0; k < arrangement.regions.size(); ++k) {
    const Label label = arrangement.regions[k].label;
    if (label == kNoLabel) continue;
    if (options.skip_base &&
        surface.steps[surface.step_of_row[static_cast<std::size_t>(row_of(label))]].solid < 0)
      continue;
    region_of.push_back(k);
    regions.push_back(
        std::make_unique<Region>(surface, arrangement, samples, deviation, options, k));
  }
  std::vector<std::vector<std::uint32_t>> users(arrangement.arcs.size());
  for (std::uint32_t r = 0; r < regions.size(); ++r) {
    for (const auto& loop : arrangement.regions[region_of[r]].loops) {
      for (const ArcUse& use : loop) {
        if (users[use.arc].empty() || users[use.arc].back() != r) users[use.arc].push_back(r);
      }
    }
  }
  std::vector<std::vector<Region::Chord>> asked(regions.size());
  // Regions of the round: those not yet done, or with a segment that has changed. The heaviest come
  // first, lest one thread be left alone with them.
  std::vector<std::uint32_t> heaviest_first(regions.size());
  std::iota(heaviest_first.begin(), heaviest_first.end(), 0U);
  std::vector<double> weight;
  for (const std::unique_ptr<Region>& region : regions) weight.push_back(region->weight());
  std::stable_sort(heaviest_first.begin(), heaviest_first.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return weight[a] > weight[b]; });
  std::vector<std::uint32_t> active = heaviest_first;
  std::vector<char> touched(regions.size());
  std::vector<char> to_build(regions.size(), 1);
  std::vector<std::size_t> crossings(regions.size(), 0);
  bool any_build = true;
  // Chords that cross are split down to the distance at which points are told apart at all.
  const double least = 1e-9 * surface.size;
  for (int round = 0; round < options.rounds + 40; ++round) {
    const bool refining = round < options.rounds;
    parallel_blocks(active.size(), 1, options.threads,
                    [&](std::size_t begin, std::size_t end, int) {
                      for (std::size_t k = begin; k < end; ++k) {
                        const std::uint32_t r = active[k];
                        asked[r].clear();
                        if (to_build[r]) {
                          asked[r] = regions[r]->build();
                          to_build[r] = !asked[r].empty() ? 1 : 0;
                        }
                        if (!to_build[r]) asked[r] = regions[r]->refine();
                      }
                    });
    any_build = std::any_of(to_build.begin(), to_build.end(), [](char b) { return b != 0; });
    // Borders that truly overlap would be split for ever, and where none of the chords that cross
    // can be split any more, the next round would find the same.
    bool hopeless = false;
    for (std::size_t r = 0; r < regions.size() && !hopeless; ++r) {
      if (to_build[r]) crossings[r] += asked[r].size();
      hopeless = to_build[r] &&
                 (crossings[r] > kMostCrossings ||
                  std::none_of(asked[r].begin(), asked[r].end(), [&](const Region::Chord& chord) {
                    return samples.can_split(chord[0], chord[1], least);
                  }));
    }
    if (hopeless) break;
    bool split_any = false;
    std::fill(touched.begin(), touched.end(), 0);
    const std::vector<char> building = to_build;  // as it was asked: a split may break a region
    for (std::size_t r = 0; r < regions.size(); ++r) {
      for (const Region::Chord& chord : asked[r]) {
        if (!refining && !building[r] && !regions[r]->urgent()) {
          regions[r]->keep(chord);
          touched[r] = 1;
          split_any = true;  // refine once more without it
          continue;
        }
        const ArcSamples::Split split = samples.split(
            chord[0], chord[1], building[r] || regions[r]->urgent() ? least : options.shortest);
        if (split.point == ArcSamples::kNone) {
          // Too short, or split already by the other side: a kept segment is told to both.
          regions[r]->keep(chord);
          touched[r] = 1;
          split_any = true;
          continue;
        }
        split_any = true;
        for (const std::uint32_t user : users[split.arc]) {
          regions[user]->take_split(chord, split.point);
          touched[user] = 1;
          if (regions[user]->broken()) to_build[user] = 1;
        }
      }
    }
    any_build = std::any_of(to_build.begin(), to_build.end(), [](char b) { return b != 0; });
    if (!split_any && !any_build) break;
    active.clear();
    for (const std::uint32_t r : heaviest_first) {
      if (touched[r] || to_build[r]) active.push_back(r);
    }
  }
  if (any_build) {
    return Error{ErrorCode::kInput,
                 "the border of a surface element crosses itself at the least distance: the part "
                 "is finer than its coordinates can tell",
                 {surface.program.file}};
  }
  std::vector<RegionMesh> meshes(regions.size());
  parallel_blocks(regions.size(), 1, options.threads, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t k = begin; k < end; ++k) {
      const std::uint32_t r = heaviest_first[k];
      meshes[r] = regions[r]->finish();
      regions[r].reset();  // its triangulation is several times as large
    }
  });
  return meshes;
}

}  // namespace diesink
