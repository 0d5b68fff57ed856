// Planar triangulation against brute force, on regular and on degenerate input.
// SPDX-License-Identifier: Apache-2.0
#include "tests/core/planar_checks.h"

namespace diesink {
namespace {

TEST(PlanarTriangulation, SquareWithHole) {
  Region region;
  region.add_loop(std::vector<Vec2>{{0, 0}, {4, 0}, {4, 4}, {0, 4}});
  region.add_loop(std::vector<Vec2>{{1, 1}, {1, 2}, {2, 2}, {2, 1}});
  PlanarTriangulation mesh;
  ASSERT_TRUE(mesh.build(region.points, region.segments).empty());
  EXPECT_EQ(mesh.triangles().size(), 8U);
  check_region(mesh.points(), region.segments, mesh.triangles(), 4);
  EXPECT_TRUE(mesh.insert({3, 3}));
  EXPECT_FALSE(mesh.insert({3, 3}));
  EXPECT_FALSE(mesh.insert({1.5, 1.5}));
  EXPECT_FALSE(mesh.insert({2, 1.5}));
  EXPECT_FALSE(mesh.insert({5, 5}));
  EXPECT_EQ(mesh.triangles().size(), 10U);
  check_region(mesh.points(), region.segments, mesh.triangles(), 4);
}

TEST(PlanarTriangulation, EmptyCirclesByBruteForce) {
  std::mt19937_64 random(5);
  for (int round = 0; round < 2000; ++round) {
    // Whole coordinates on a small board: many points in line and on one circle.
    const int board = 4 + static_cast<int>(random() % 12);
    std::set<std::pair<int, int>> places;
    const std::size_t count = 1 + random() % 24;
    for (std::size_t i = 0; i < count; ++i) {
      places.emplace(1 + random() % static_cast<unsigned>(board),
                     1 + random() % static_cast<unsigned>(board));
    }
    Region region;
    const double end = board + 1;
    region.add_loop(std::vector<Vec2>{{0, 0}, {end, 0}, {end, end}, {0, end}});
    for (const auto& [x, y] : places) region.points.emplace_back(x, y);
    std::shuffle(region.points.begin() + 4, region.points.end(), random);
    PlanarTriangulation mesh;
    ASSERT_TRUE(mesh.build(region.points, region.segments).empty());
    const std::vector<Corners> triangles = mesh.triangles();
    ASSERT_EQ(triangles.size(), 2 * region.points.size() - 6);
    check_region(mesh.points(), region.segments, triangles, end);
    for (const Corners& t : triangles) {
      ASSERT_GT(twice_area(region.points[t[0]], region.points[t[1]], region.points[t[2]]), 0);
      for (const Vec2& p : region.points) {
        ASSERT_LE(in_circle_value(region.points[t[0]], region.points[t[1]], region.points[t[2]], p),
                  0);
      }
    }
  }
}

}  // namespace
}  // namespace diesink
