// Refinement in rounds: the caller splits the segments that are asked for.
// SPDX-License-Identifier: Apache-2.0
#include "tests/core/planar_checks.h"

namespace diesink {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

// Where a segment is split; default the middle of the chord.
using Split = std::function<Vec2(const Vec2&, const Vec2&)>;

// Refines and splits until nothing is asked for; the number of rounds, or 1000.
int refine_all(PlanarTriangulation& mesh, std::vector<Segment>& segments, const RefineRules& rules,
               const Split& split = {}) {
  for (int round = 1; round < 200; ++round) {
    const std::vector<Segment> requests = mesh.refine(rules);
    if (requests.empty()) return round;
    std::set<Segment> known;
    for (const Segment& s : segments) known.insert({std::min(s[0], s[1]), std::max(s[0], s[1])});
    std::map<Segment, std::uint32_t> middles;
    for (const Segment& s : requests) {
      EXPECT_EQ(known.erase(s), 1U) << "asked for twice, or no segment";
      const Vec2 a = mesh.points()[s[0]], b = mesh.points()[s[1]];
      const auto vertex = static_cast<std::uint32_t>(mesh.points().size());
      if (mesh.split_segment(s[0], s[1], split ? split(a, b) : Vec2(0.5 * (a + b)))) {
        middles[s] = vertex;
      }
    }
    for (std::size_t i = segments.size(); i-- > 0;) {
      const Segment s = segments[i];
      const auto at = middles.find({std::min(s[0], s[1]), std::max(s[0], s[1])});
      if (at == middles.end()) continue;
      segments[i][1] = at->second;
      segments.push_back({at->second, s[1]});
    }
    if (middles.empty()) break;
  }
  return 1000;
}

double least_angle(const PlanarTriangulation& mesh) {
  double least = 10;
  const std::span<const Vec2> p = mesh.points();
  for (const Corners& t : mesh.triangles()) {
    least = std::min(least, smallest_angle(p[t[0]], p[t[1]], p[t[2]]));
  }
  return least;
}

double area_of(const PlanarTriangulation& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  const std::span<const Vec2> p = mesh.points();
  return 0.5 * static_cast<double>(twice_area(p[a], p[b], p[c]));
}

// Squares and polygons with corners of 60 degrees and more, apart from each other.
Region blunt_region(std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  Region region;
  region.add_loop(std::vector<Vec2>{{0, 0}, {4, 0}, {4, 3 + unit(random)}, {0, 4}});
  for (int x = 0; x < 3; ++x) {
    for (int y = 0; y < 3; ++y) {
      if (random() % 3 == 0) continue;
      const int corners = random() % 2 == 0 ? 3 + static_cast<int>(random() % 4)
                                            : static_cast<int>(8 + random() % 60);
      const double radius = std::pow(10.0, -2.5 * unit(random)) * 0.45;
      region.add_loop(circle({1.0 + x, 0.6 + 0.9 * y}, radius, corners, true, 6 * unit(random)));
    }
  }
  return region;
}

TEST(PlanarRefinement, ReachesTheAngle) {
  std::mt19937_64 random(17);
  for (int k = 0; k < 150; ++k) {
    SCOPED_TRACE(k);
    Region region = blunt_region(random);
    const std::vector<Vec2> input = region.points;
    PlanarTriangulation mesh;
    ASSERT_TRUE(mesh.build(region.points, region.segments).empty());
    RefineRules rules;
    rules.min_angle = (k % 2 == 0 ? 20 : 25) * kDegree;
    rules.split_encroached = k % 3 != 0;
    ASSERT_LE(refine_all(mesh, region.segments, rules), 40);
    ASSERT_GE(least_angle(mesh), rules.min_angle);
    check_region(mesh.points(), region.segments, mesh.triangles(), 4);
    if (HasFatalFailure()) return;
    ASSERT_TRUE(std::equal(input.begin(), input.end(), mesh.points().begin()));
    if (!rules.split_encroached) continue;
    const std::span<const Vec2> p = mesh.points();
    const std::set<Segment> border(region.segments.begin(), region.segments.end());
    for (const Corners& t : mesh.triangles()) {
      for (std::size_t e = 0; e < 3; ++e) {
        const std::uint32_t a = t[e], b = t[(e + 1) % 3], c = t[(e + 2) % 3];
        if (border.count({a, b}) == 0 || border.count({b, c}) != 0 || border.count({c, a}) != 0) {
          continue;
        }
        ASSERT_GE((p[a] - p[c]).dot(p[b] - p[c]), 0) << "a vertex in a diametral circle";
      }
    }
  }
}

TEST(PlanarRefinement, KeepsTheAccuracy) {
  std::mt19937_64 random(23);
  for (int k = 0; k < 40; ++k) {
    SCOPED_TRACE(k);
    Region region = blunt_region(random);
    PlanarTriangulation mesh;
    ASSERT_TRUE(mesh.build(region.points, region.segments).empty());
    const double most = 0.003;
    std::vector<Vec2> added;
    RefineRules rules;
    rules.min_angle = k % 2 == 0 ? 20 * kDegree : 0;
    rules.too_coarse = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
      return area_of(mesh, a, b, c) > most;
    };
    rules.add_vertex = [&](const Vec2& p, double) {
      added.push_back(p);
      return true;
    };
    ASSERT_LE(refine_all(mesh, region.segments, rules), 40);
    check_region(mesh.points(), region.segments, mesh.triangles(), 4);
    if (HasFatalFailure()) return;
    for (const Corners& t : mesh.triangles()) ASSERT_LE(area_of(mesh, t[0], t[1], t[2]), most);
    ASSERT_TRUE(k % 2 != 0 || least_angle(mesh) >= rules.min_angle);
    // What was announced is what is there, in this order among the splits.
    std::size_t i = region.points.size();
    for (const Vec2& p : added) {
      while (i < mesh.points().size() && mesh.points()[i] != p) ++i;
      ASSERT_LT(i, mesh.points().size());
    }
    // No more than a few times as many as the area alone would need.
    ASSERT_LT(mesh.triangles().size(), 6 * 16 / most);
  }
}

// Vertices on the arcs themselves, off the chords, to one side or the other.
TEST(PlanarRefinement, FollowsArcs) {
  for (const double radius : {0.35, 0.6, 0.9, 0.97}) {
    Region region;
    region.add_loop(circle({0, 0}, 1, 24));
    region.add_loop(circle({0, 0}, radius, 12, true));
    PlanarTriangulation mesh;
    const auto on_arc = [&](const Vec2& a, const Vec2& b) {
      return Vec2((0.5 * (a + b)).normalized() * (a.norm() > 0.5 * (1 + radius) ? 1 : radius));
    };
    RefineRules rules;
    rules.min_angle = 20 * kDegree;
    ASSERT_TRUE(mesh.build(region.points, region.segments).empty());
    rules.too_coarse = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
      return area_of(mesh, a, b, c) > 1e-3;
    };
    ASSERT_LE(refine_all(mesh, region.segments, rules, on_arc), 40);
    ASSERT_GE(least_angle(mesh), rules.min_angle);
    check_region(mesh.points(), region.segments, mesh.triangles(), 1);
    double area = 0;
    for (const Corners& t : mesh.triangles()) area += area_of(mesh, t[0], t[1], t[2]);
    EXPECT_NEAR(area, std::numbers::pi * (1 - radius * radius), 0.01);
  }
}

TEST(PlanarRefinement, SmallAnglesEnd) {
  for (const double degrees : {0.1, 1.0, 6.0, 17.0, 31.0, 45.0}) {
    SCOPED_TRACE(degrees);
    // A fan of slits of unlike lengths, in a square cut by a wedge.
    Region region;
    region.add_loop(std::vector<Vec2>{{-1, -1},
                                      {1, -1},
                                      {1, 1},
                                      {-1, 1},
                                      {-1, 0.1},
                                      {-0.6, 0.1},
                                      {-1, 0.1 - 0.4 * std::tan(degrees * kDegree)}});
    const auto hub = static_cast<std::uint32_t>(region.points.size());
    region.points.emplace_back(0, 0);
    for (int i = 0; i * degrees < 359 && i < 60; ++i) {
      const double angle = i * degrees * kDegree, length = 0.1 + 0.4 * (i * 7919 % 13) / 13;
      region.points.push_back(length * Vec2(std::cos(angle), std::sin(angle)));
      const auto end = static_cast<std::uint32_t>(region.points.size() - 1);
      region.segments.push_back({hub, end});
      region.segments.push_back({end, hub});
    }
    PlanarTriangulation mesh;
    ASSERT_TRUE(mesh.build(region.points, region.segments).empty());
    RefineRules rules;
    rules.min_angle = 25 * kDegree;
    ASSERT_LE(refine_all(mesh, region.segments, rules), 60);
    check_region(mesh.points(), region.segments, mesh.triangles(), 2);
    if (HasFatalFailure()) return;
    EXPECT_LT(mesh.triangles().size(), 20000U);
  }
}

// Polygons with any angles: an end is reached, and what is there is a triangulation.
TEST(PlanarRefinement, SharpStarsEnd) {
  std::mt19937_64 random(29);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int k = 0; k < 150; ++k) {
    SCOPED_TRACE(k);
    Region region;
    std::vector<Vec2> star;
    const int corners = 3 + static_cast<int>(random() % 40);
    for (int i = 0; i < corners; ++i) {
      const double angle = 2 * std::numbers::pi * (i + 0.9 * unit(random)) / corners;
      star.push_back((0.02 + unit(random)) * Vec2(std::cos(angle), std::sin(angle)));
    }
    region.add_loop(star);
    std::reverse(star.begin(), star.end());
    for (Vec2& p : star) p *= 0.1;
    region.add_loop(star);
    PlanarTriangulation mesh;
    if (!mesh.build(region.points, region.segments).empty()) continue;
    RefineRules rules;
    rules.min_angle = 22 * kDegree;
    rules.shortest_edge = k % 2 == 0 ? 1e-3 : 0;
    ASSERT_LE(refine_all(mesh, region.segments, rules), 60);
    check_region(mesh.points(), region.segments, mesh.triangles(), 2);
    if (HasFatalFailure()) return;
    ASSERT_LT(mesh.triangles().size(), 20000U);
  }
}

TEST(PlanarRefinement, GoesOnWhereItStopped) {
  Region region;
  region.add_loop(circle({0, 0}, 1, 500));  // so fine that no segment needs a split
  RefineRules rules;
  rules.min_angle = 25 * kDegree;
  PlanarTriangulation whole, steps;
  ASSERT_TRUE(whole.build(region.points, region.segments).empty());
  ASSERT_TRUE(steps.build(region.points, region.segments).empty());
  ASSERT_TRUE(whole.refine(rules).empty());
  std::size_t before = 0;
  rules.max_vertices = steps.points().size();
  while (before != steps.points().size()) {
    before = steps.points().size();
    rules.max_vertices = before + 7;
    ASSERT_TRUE(steps.refine(rules).empty());
    ASSERT_LE(steps.points().size(), rules.max_vertices);
  }
  EXPECT_EQ(whole.triangles(), steps.triangles());

  // Nothing to do the second time, not even a look at the triangles.
  std::size_t looks = 0;
  rules.too_coarse = [&](std::uint32_t, std::uint32_t, std::uint32_t) {
    ++looks;
    return false;
  };
  const std::size_t count = whole.points().size();
  rules.max_vertices = 1000000;
  EXPECT_TRUE(whole.refine(rules).empty());
  EXPECT_EQ(looks, 0U);
  EXPECT_EQ(whole.points().size(), count);
  // Another angle is another question.
  rules.min_angle = 28 * kDegree;
  EXPECT_TRUE(whole.refine(rules).empty());
  EXPECT_GT(looks, 0U);
  EXPECT_GE(least_angle(whole), rules.min_angle);
}

// Ten times as long as wide: its border has to be split before it can be refined.
PlanarTriangulation slab() {
  Region region;
  region.add_loop(std::vector<Vec2>{{0, 0}, {10, 0}, {10, 1}, {0, 1}});
  PlanarTriangulation mesh;
  EXPECT_TRUE(mesh.build(region.points, region.segments).empty());
  return mesh;
}

TEST(PlanarRefinement, AsksAgainForWhatWasNotSplit) {
  PlanarTriangulation mesh = slab();
  RefineRules rules;
  rules.min_angle = 20 * kDegree;
  std::vector<Segment> first = mesh.refine(rules), second = mesh.refine(rules);
  std::sort(first.begin(), first.end());
  std::sort(second.begin(), second.end());
  EXPECT_FALSE(first.empty());
  EXPECT_EQ(first, second);
  // Kept segments are asked for no more.
  for (const Segment& s : first) EXPECT_TRUE(mesh.keep_segment(s[0], s[1]));
  EXPECT_FALSE(mesh.keep_segment(0, 2));
  EXPECT_FALSE(mesh.keep_segment(0, 99));
  for (const Segment& s : mesh.refine(rules)) {
    EXPECT_EQ(std::count(first.begin(), first.end(), s), 0) << s[0] << ' ' << s[1];
  }
}

// Where nobody splits them: a triangle that waits for accuracy, for shape and for the front waits
// once, or every round would look at it twice as often as the last.
TEST(PlanarRefinement, WaitsOnceWithEachTriangle) {
  PlanarTriangulation mesh = slab();
  RefineRules rules;
  rules.min_angle = 20 * kDegree;
  rules.spacing = [](std::uint32_t) { return 5.0; };
  std::size_t looks = 0;
  rules.too_coarse = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    ++looks;
    return area_of(mesh, a, b, c) > 0.01;
  };
  for (int round = 0; round < 4; ++round) EXPECT_FALSE(mesh.refine(rules).empty());
  const std::size_t triangles = mesh.triangles().size();
  for (int round = 0; round < 12; ++round) {
    looks = 0;
    EXPECT_FALSE(mesh.refine(rules).empty());
  }
  ASSERT_EQ(mesh.triangles().size(), triangles);
  EXPECT_GT(looks, 0U);
  EXPECT_LE(looks, 4 * triangles);
}

TEST(PlanarRefinement, WorksBesideKeptSegments) {
  Region region;
  region.add_loop(std::vector<Vec2>{{0, 0}, {4, 0}, {4, 3}, {0, 3}});
  region.add_loop(circle({2, 1.5}, 0.5, 5, true));
  PlanarTriangulation mesh;
  ASSERT_TRUE(mesh.build(region.points, region.segments).empty());
  for (const Segment& s : region.segments) ASSERT_TRUE(mesh.keep_segment(s[0], s[1]));
  RefineRules rules;
  rules.min_angle = 20 * kDegree;
  rules.max_vertices = 20000;
  const double most = 0.3;
  rules.too_coarse = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    return area_of(mesh, a, b, c) > most;
  };
  EXPECT_TRUE(mesh.refine(rules).empty());
  check_region(mesh.points(), region.segments, mesh.triangles(), 4);
  EXPECT_LT(mesh.points().size(), 2000U);
  // Few stay too large: what would mend them would lie flat on a segment.
  std::size_t large = 0;
  for (const Corners& t : mesh.triangles()) {
    if (area_of(mesh, t[0], t[1], t[2]) > most) ++large;
  }
  EXPECT_LE(large, region.segments.size());
  EXPECT_GT(mesh.triangles().size(), 30U);
}

TEST(PlanarRefinement, LeavesAloneWhatIsRefused) {
  Region region;
  region.add_loop(circle({0, 0}, 1, 100));
  PlanarTriangulation mesh;
  ASSERT_TRUE(mesh.build(region.points, region.segments).empty());
  const std::vector<Corners> before = mesh.triangles();
  std::size_t asked = 0;
  RefineRules rules;
  rules.min_angle = 20 * kDegree;
  rules.add_vertex = [&](const Vec2&, double) {
    ++asked;
    return false;
  };
  EXPECT_TRUE(mesh.refine(rules).empty());
  EXPECT_EQ(mesh.triangles(), before);
  EXPECT_GT(asked, 0U);
  EXPECT_LE(asked, before.size());
}

TEST(PlanarRefinement, KeepsTheShortestEdge) {
  Region region;
  region.add_loop(std::vector<Vec2>{{0, 0}, {4, 0}, {4, 0.3}, {2, 0.7}, {0, 0.2}});
  PlanarTriangulation mesh;
  ASSERT_TRUE(mesh.build(region.points, region.segments).empty());
  RefineRules rules;
  rules.min_angle = 30 * kDegree;
  rules.shortest_edge = 0.15;
  ASSERT_LE(refine_all(mesh, region.segments, rules), 40);
  const std::span<const Vec2> p = mesh.points();
  EXPECT_GT(p.size(), region.points.size());
  for (const Corners& t : mesh.triangles()) {
    for (std::size_t e = 0; e < 3; ++e) {
      EXPECT_GE((p[t[e]] - p[t[(e + 1) % 3]]).norm(), rules.shortest_edge * (1 - 1e-12));
    }
  }
}

}  // namespace
}  // namespace diesink
