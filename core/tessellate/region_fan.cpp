// The side of a cone with a ruling that is all but upright, about its apex: triangles between
// rulings, as no others look up there however small they are.
// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/exact_plan.h"
#include "core/tessellate/region_mesher.h"

namespace diesink {
namespace {

// Upright part of a unit normal under which refinement takes many triangles to follow a ruling
// (2.9 degrees: 1200 for 180 at 0.05 on a cone of 15 mm, and without end at 0).
constexpr double kAllButUpright = 0.05;

// Of the tolerance: chords this short over the ruling are as good as a point. They leave the plan
// of the ruling by their square over eight radii, which is rounding.
constexpr double kPoint = 1e-3;
// Of the tolerance: triangles over chords this short deviate by no more than what a shorter chord
// cannot mend.
constexpr double kMended = 0.25;

// Sine of the angle to a ruling under which a chord is one of its own: chords across have some
// tenths, those of a silhouette what is left of points a tenth of a micrometre apart.
constexpr double kAlong = 1e-3;

}  // namespace

// One loop round the apex, or from it along a ruling, across and back along another, that every
// ruling between meets once; false leaves the region to refinement.
bool RegionMesher::make_fan(const std::vector<PlanarTriangulation::Segment>& border) {
  const std::optional<Vec3> apex = chart_.apex();
  if (!apex || options_.grid_x != nullptr || border.size() < 3 ||
      arrangement_.regions[mesh_.region].loops.size() != 1)
    return false;
  const std::optional<std::uint32_t> vertex = border_vertex_at(*apex);
  for (std::size_t k = 0; vertex && k < border.size(); ++k) {
    if (border[k][0] != *vertex) continue;
    std::vector<PlanarTriangulation::Segment> from_apex = border;
    std::rotate(from_apex.begin(), from_apex.begin() + static_cast<std::ptrdiff_t>(k),
                from_apex.end());
    return make_fan_between(from_apex, *apex);
  }
  return make_fan_around(border, *apex);
}

// (The chart is a disk about the apex where all of the side is seen.)
bool RegionMesher::make_fan_around(const std::vector<PlanarTriangulation::Segment>& border,
                                   const Vec3& apex) {
  const auto is_steep = [&](const Vec3& p) {
    return std::fabs(chart_.normal(p).z()) < kAllButUpright;
  };
  if (std::none_of(mesh_.position.begin(), mesh_.position.end(), is_steep)) return false;
  const Vec2 o = chart_.to_chart(apex);
  double round = 0;
  for (const auto& [a, b] : border) {
    const Vec2 p = points_[a] - o, q = points_[b] - o;
    if (turn(o.x(), o.y(), points_[a].x(), points_[a].y(), points_[b].x(), points_[b].y()) <= 0)
      return false;
    round += std::atan2(p.x() * q.y() - p.y() * q.x(), p.dot(q));
  }
  if (std::fabs(round - 2 * std::numbers::pi) > 1) return false;  // once round, not twice
  const auto centre = static_cast<std::uint32_t>(mesh_.position.size());
  mesh_.arc_point.push_back(ArcSamples::kNone);
  mesh_.position.push_back(apex);
  mesh_.border_bound.push_back(0);
  for (const auto& [a, b] : border) fan_.push_back({{a, b, centre}, {a, b}});
  return true;
}

// Where the apex stands out over the rim the side is seen between the two rulings of its
// silhouette. What of these is all but upright has no room beside it for triangles of any size.
bool RegionMesher::make_fan_between(const std::vector<PlanarTriangulation::Segment>& border,
                                    const Vec3& apex) {
  const std::size_t n = border.size();
  const auto at = [&](std::size_t k) { return mesh_.position[border[k % n][0]]; };
  const auto on_ruling = [&](std::size_t from, std::size_t to) {
    const Vec3 far = at(to) - apex, chord = at(to) - at(from);
    return far.cross(chord).norm() <= kAlong * far.norm() * chord.norm();
  };
  std::size_t first = 1, last = n - 1;  // the ends of both rulings
  while (first + 1 < n && on_ruling(first, first + 1)) ++first;
  while (last > first && on_ruling(last, last - 1)) --last;
  if (last < first + 2) return false;
  const auto is_steep = [&](std::size_t k) {
    const Vec3 ruling = at(k) - apex;
    return ruling.head<2>().norm() < kAllButUpright * ruling.norm();
  };
  if (!is_steep(first) && !is_steep(last)) return false;
  const Vec2 o = chart_.to_chart(apex);
  const auto vertex = [&](std::size_t k) { return border[k % n][0]; };
  for (std::size_t k = first; k < last; ++k) {
    const Vec2 &p = points_[vertex(k)], &q = points_[vertex(k + 1)];
    if (turn(o.x(), o.y(), p.x(), p.y(), q.x(), q.y()) <= 0) return false;
  }
  const auto add = [&](std::size_t a, std::size_t b, std::size_t c, std::size_t chord) {
    fan_.push_back({{vertex(a), vertex(b), vertex(c)}, {vertex(chord), vertex(chord + 1)}});
  };
  // Rulings that have points of their own go to the far end of the chord beside them.
  for (std::size_t k = 0; k < first; ++k) add(k, k + 1, first + 1, first);
  for (std::size_t k = first + 1; k + 1 < last; ++k) add(k, k + 1, 0, k);
  for (std::size_t k = last; k < n; ++k) add(k, k + 1, last - 1, last - 1);
  return true;
}

// Chords over the upright ruling whose triangles look down, until they are of no height.
std::vector<RegionMesher::Chord> RegionMesher::chords_of_fan() const {
  std::vector<Chord> chords;
  for (const FanPiece& piece : fan_) {
    const auto& [a, b, c] = piece.triangle;
    const std::array<std::uint32_t, 2>& chord = piece.across;
    const double length = (mesh_.position[chord[0]] - mesh_.position[chord[1]]).norm();
    // (In a strip, over rulings with a vertex at both ends, it is rounding that looks down.)
    const bool turned = looks_down(a, b, c) && !is_strip_;
    if (turned ? length > kPoint * options_.tolerance
               : length > kMended * options_.tolerance && deviates(piece))
      chords.push_back({mesh_.arc_point[chord[0]], mesh_.arc_point[chord[1]]});
  }
  std::sort(chords.begin(), chords.end());
  chords.erase(std::unique(chords.begin(), chords.end()), chords.end());
  return chords;
}

// What looks down all the same about an apex stands over a chord too short to see: it is a piece of
// wall between the ruling and what lies under it. (In a strip it is laid anew, or told.)
void RegionMesher::finish_fan() {
  for (const auto& [t, chord] : fan_) {
    const auto& [a, b, c] = t;
    if (!is_strip_ && (looks_down(a, b, c) || may_round_down(a, b, c))) {
      mesh_.upright.push_back(t);
    } else {
      mesh_.triangles.push_back(t);
    }
  }
}

}  // namespace diesink
