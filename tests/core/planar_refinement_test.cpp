// Refinement in rounds: the caller splits the segments that are asked for.
// SPDX-License-Identifier: Apache-2.0
#include "tests/core/planar_checks.h"

namespace diesink {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

// Refines and splits at the middles of chords until nothing is asked for; returns the rounds.
int refine_straight(PlanarTriangulation& mesh, std::vector<Segment>& segments,
                    const RefineRules& rules, int most_rounds = 60) {
  for (int round = 1; round <= most_rounds; ++round) {
    const std::vector<Segment> requests = mesh.refine(rules);
    if (requests.empty()) return round;
    for (const Segment& s : requests) {
      const Vec2 middle = 0.5 * (mesh.points()[s[0]] + mesh.points()[s[1]]);
      const auto vertex = static_cast<std::uint32_t>(mesh.points().size());
      if (!mesh.split_segment(s[0], s[1], middle)) continue;
      std::vector<Segment> halves;
      for (Segment& t : segments) {
        if (t != s && t != Segment{s[1], s[0]}) continue;
        halves.push_back({vertex, t[1]});
        t[1] = vertex;
      }
      segments.insert(segments.end(), halves.begin(), halves.end());
    }
  }
  return most_rounds + 1;
}

double least_angle(const PlanarTriangulation& mesh) {
  double least = 10;
  for (const Corners& t : mesh.triangles()) {
    least = std::min(least,
                     smallest_angle(mesh.points()[t[0]], mesh.points()[t[1]], mesh.points()[t[2]]));
  }
  return least;
}

TEST(PlanarRefinement, ReachesTheAngle) {
  Region region;
  region.add_loop(std::vector<Vec2>{{0, 0}, {10, 0}, {10, 1}, {0, 1}});
  region.add_loop(circle({2, 0.5}, 0.2, 40, true));
  PlanarTriangulation mesh;
  ASSERT_TRUE(mesh.build(region.points, region.segments).empty());
  RefineRules rules;
  rules.min_angle = 20 * kDegree;
  const int rounds = refine_straight(mesh, region.segments, rules);
  EXPECT_LE(rounds, 20);
  EXPECT_GE(least_angle(mesh), rules.min_angle);
  check_region(mesh.points(), region.segments, mesh.triangles(), 10);
}

}  // namespace
}  // namespace diesink
