// The side of a cone with a ruling that is all but upright, about its apex: triangles between
// rulings, as no others look up there however small they are.
// SPDX-License-Identifier: Apache-2.0
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

}  // namespace

// One loop round the apex that every ruling meets once; false leaves the region to refinement.
// (The chart is a disk about the apex where all of the side is seen.)
bool RegionMesher::make_fan(const std::vector<PlanarTriangulation::Segment>& border) {
  const std::optional<Vec3> apex = chart_.apex();
  if (!apex || options_.grid_x != nullptr || border.size() < 3 ||
      arrangement_.regions[mesh_.region].loops.size() != 1)
    return false;
  const auto is_steep = [&](const Vec3& p) {
    return std::fabs(chart_.normal(p).z()) < kAllButUpright;
  };
  if (std::none_of(mesh_.position.begin(), mesh_.position.end(), is_steep)) return false;
  const Vec2 o = chart_.to_chart(*apex);
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
  mesh_.position.push_back(*apex);
  mesh_.border_bound.push_back(0);
  fan_.clear();
  for (const auto& [a, b] : border) fan_.push_back({a, b, centre});
  return true;
}

// Chords over the upright ruling whose triangles look down, until they are of no height.
std::vector<RegionMesher::Chord> RegionMesher::chords_of_fan() const {
  std::vector<Chord> chords;
  for (const auto& [a, b, apex] : fan_) {
    const bool is_short =
        (mesh_.position[a] - mesh_.position[b]).norm() <= kPoint * options_.tolerance;
    if (looks_down(a, b, apex)
            ? !is_short
            : bound_of(face_bound_of(a, b, apex), a, b, apex) > options_.tolerance)
      chords.push_back({mesh_.arc_point[a], mesh_.arc_point[b]});
  }
  return chords;
}

// What looks down all the same stands over a chord too short to see: it is a piece of wall between
// the ruling and what lies under it.
void RegionMesher::finish_fan() {
  for (const auto& t : fan_) {
    const auto& [a, b, apex] = t;
    if (looks_down(a, b, apex) || may_round_down(a, b, apex)) {
      mesh_.upright.push_back(t);
    } else {
      mesh_.triangles.push_back(t);
    }
  }
}

}  // namespace diesink
