// What is seen of scans that lie over themselves: all of it, nowhere twice, as points find it.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <utility>

#include "core/base/scan_cracks.h"
#include "core/base/scan_sheet.h"
#include "tests/support/scans.h"

namespace diesink::test {
namespace {

// A closed prism of n sides that leans by `lean` of its height: straight walls where that is 0.
void add_prism(TriangleMesh& mesh, const Vec3& centre, std::uint32_t n, double radius,
               double height, double turned, const Vec2& lean) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const double level : {-0.5, 0.5}) {
    for (std::uint32_t k = 0; k < n; ++k) {
      const double a = turned + 2 * std::numbers::pi * k / n;
      mesh.positions.emplace_back(centre.x() + radius * std::cos(a) + level * height * lean.x(),
                                  centre.y() + radius * std::sin(a) + level * height * lean.y(),
                                  centre.z() + level * height);
    }
  }
  for (std::uint32_t k = 0; k < n; ++k) {
    const std::uint32_t a = first + k, b = first + (k + 1) % n, c = a + n, d = b + n;
    mesh.triangles.push_back({a, b, d});
    mesh.triangles.push_back({a, d, c});
    if (k == 0 || k + 1 == n) continue;
    mesh.triangles.push_back({first, b, a});
    mesh.triangles.push_back({first + n, c, d});
  }
}

double area_of(const ScanSheet& sheet, double& down) {
  double area = 0;
  for (const auto& t : sheet.triangles) {
    const Vec3 u = sheet.points[t[1]] - sheet.points[t[0]],
               v = sheet.points[t[2]] - sheet.points[t[0]];
    const double twice = u.x() * v.y() - u.y() * v.x();
    down += std::fmax(-twice, 0.0);
    area += 0.5 * twice;
  }
  return area;
}

// The sheet against the scan at random points: the same height, or where something stands within
// `moved` of it a height between those about.
void expect_seen(const TriangleMesh& mesh, double lean, std::uint32_t seed) {
  const ScannedSurface scan = scan_of(mesh);
  const PlanBox box = scan.plan_box();
  const ScanSheet sheet = top_sheet(scan, box, lean, 1);
  EXPECT_EQ(sheet.unproven_area, 0);
  EXPECT_LE(sheet.moved, 2 * lean);
  double down = 0;
  const double area = area_of(sheet, down);
  EXPECT_LE(down, 1e-9);
  TriangleMesh seen;
  seen.positions = sheet.points;
  seen.triangles = sheet.triangles;
  const ScannedSurface top = scan_of(seen);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> x(box.x0, box.x1), y(box.y0, box.y1);
  constexpr int kPoints = 20'000;
  int covered = 0, there = 0;
  for (int k = 0; k < kPoints; ++k) {
    const double px = x(random), py = y(random);
    BaseHit of_scan, of_sheet;
    const bool in_scan = scan.at(px, py, of_scan), in_sheet = top.at(px, py, of_sheet);
    covered += in_scan;
    there += in_sheet;
    if (in_scan && in_sheet && std::fabs(of_scan.z - of_sheet.z) <= 1e-6 * lean) continue;
    // The lowest and the highest about.
    double low = in_scan ? of_scan.z : HUGE_VAL, high = in_scan ? of_scan.z : -HUGE_VAL;
    bool open = !in_scan;
    for (int a = 0; a < 32; ++a) {
      for (const double r : {0.25, 0.5, 1.0}) {
        const double w = 2 * std::numbers::pi * a / 32, d = 1.01 * r * sheet.moved;
        BaseHit h;
        if (scan.at(px + d * std::cos(w), py + d * std::sin(w), h)) {
          low = std::fmin(low, h.z);
          high = std::fmax(high, h.z);
        } else {
          open = true;
        }
      }
    }
    const bool between =
        in_sheet ? of_sheet.z >= low - 4 * lean && of_sheet.z <= high + 4 * lean : open;
    EXPECT_TRUE(between) << px << ' ' << py << ": " << of_sheet.z << ", not in " << low << " .. "
                         << high;
    if (!between) return;
  }
  // Nothing is twice there: the triangles have the area that points find.
  const double whole = (box.x1 - box.x0) * (box.y1 - box.y0);
  EXPECT_NEAR(area / whole, static_cast<double>(there) / kPoints, 0.02);
  EXPECT_NEAR(covered, there, 0.01 * kPoints);
}

TEST(ScanLayers, PrismsThroughAndOverOneAnother) {
  for (std::uint32_t seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> part(0, 1);
    TriangleMesh mesh;
    for (int k = 0; k < 24; ++k) {
      const bool leans = part(random) < 0.4;
      const Vec2 lean = leans ? Vec2(2 * part(random) - 1, 2 * part(random) - 1) : Vec2(0, 0);
      add_prism(mesh, {60 * part(random), 40 * part(random), 20 * part(random)},
                3 + static_cast<std::uint32_t>(6 * part(random)), 3 + 9 * part(random),
                2 + 10 * part(random), 6 * part(random), lean);
    }
    expect_seen(mesh, 0.002, seed);
  }
}

// Walls that stand in line, in corners and on one another's edges, over a grid of whole numbers.
TEST(ScanLayers, BlocksOnTheLinesOfAGrid) {
  for (std::uint32_t seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    std::uniform_int_distribution<int> at(0, 12), high(1, 4);
    TriangleMesh mesh;
    const double half = std::sqrt(0.5);
    for (int k = 0; k < 30; ++k) {
      add_prism(mesh, {5.0 * at(random), 5.0 * at(random), 2.0 * high(random)}, 4,
                half * 5 * high(random), 2.0 * high(random), std::numbers::pi / 4, {0, 0});
    }
    expect_seen(mesh, 0.002, seed);
  }
}

// Three heights at one vertex: between the two lower ones the step is as high as they are apart,
// not as high as the vertex.
TEST(ScanLayers, AStepThatEndsUnderATower) {
  TriangleMesh mesh;
  add_prism(mesh, {-5, 0, -1}, 4, std::sqrt(50), 2, std::numbers::pi / 4, {0, 0});
  add_prism(mesh, {5, 0, -1.5}, 4, std::sqrt(50), 1, std::numbers::pi / 4, {0, 0});
  add_prism(mesh, {0, 4, 10}, 4, std::sqrt(2), 40, std::numbers::pi / 4, {0, 0});
  expect_seen(mesh, 0.01, 1);
  const ScannedSurface scan = scan_of(mesh);
  const ScanSheet sheet = top_sheet(scan, scan.plan_box(), 0.01, 1);
  TriangleMesh seen;
  seen.positions = sheet.points;
  seen.triangles = sheet.triangles;
  const ScannedSurface top = scan_of(seen);
  for (double y = -4.9; y < 2.9; y += 0.1) {
    for (double x = -0.011; x < 0.0115; x += 0.001) {
      BaseHit hit;
      ASSERT_TRUE(top.at(x, y, hit));
      EXPECT_LE(hit.z, 1e-9) << x << ' ' << y;
    }
  }
}

// Winding stairs: of many heights at one vertex each step down moves it on, never beyond twice the
// strips' width.
TEST(ScanLayers, WindingStairsAroundOneVertex) {
  for (const int steps : {4, 6, 9}) {
    SCOPED_TRACE(steps);
    TriangleMesh mesh;
    for (int k = 0; k < steps; ++k) {
      const auto first = static_cast<std::uint32_t>(mesh.positions.size());
      for (const double z : {-1.0, 2.0 * (steps - k)}) {
        mesh.positions.emplace_back(0, 0, z);
        for (const int end : {k, k + 1}) {
          const double a = 2 * std::numbers::pi * (end % steps) / steps;
          mesh.positions.emplace_back(10 * std::cos(a), 10 * std::sin(a), z);
        }
      }
      mesh.triangles.push_back({first, first + 2, first + 1});
      mesh.triangles.push_back({first + 3, first + 4, first + 5});
      for (std::uint32_t a = 0; a < 3; ++a) {
        const std::uint32_t b = (a + 1) % 3;
        mesh.triangles.push_back({first + a, first + b, first + b + 3});
        mesh.triangles.push_back({first + a, first + b + 3, first + a + 3});
      }
    }
    expect_seen(mesh, 0.01, 1);
  }
}

// Triangles that stand twice in a file, the second with its corners in another order: rounding
// makes now the one the higher, now the other. A third one hangs a hair above some.
TEST(ScanLayers, TrianglesTwiceAndTurnedOver) {
  TriangleMesh mesh = shaken_relief(24, 5);
  const std::size_t given = mesh.triangles.size();
  for (std::size_t t = 0; t < given; t += 7) {
    const auto [a, b, c] = mesh.triangles[t];
    mesh.triangles.push_back({b, a, c});
    if (t % 2 == 0) continue;
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const std::uint32_t v : {a, b, c}) {
      const Vec3 p = mesh.positions[v] + Vec3(0, 0, 0.001);
      mesh.positions.push_back(p);
    }
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  expect_seen(mesh, 0.02, 1);
}

// Two scans of one thing: some vertices of the second lie beside the first one's, on its edges.
// What no line crossed has lines that end on its sides all the same.
TEST(ScanLayers, TheSameScanTwiceWithSomeVerticesBesideThemselves) {
  for (std::uint32_t seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    TriangleMesh mesh = height_mesh(0, 40, 14, 0, 40, 16, [](double x, double y) {
      return 3 * std::sin(x / 9) * std::cos(y / 7);
    });
    const auto count = static_cast<std::uint32_t>(mesh.positions.size());
    for (std::uint32_t v = 0; v < count; ++v) {
      const Vec3 p = mesh.positions[v] + Vec3(random() % 2 == 0 ? 0.01 : 0, 0, 0);
      mesh.positions.push_back(p);
    }
    const std::size_t given = mesh.triangles.size();
    for (std::size_t t = 0; t < given; ++t) {
      const auto [a, b, c] = mesh.triangles[t];
      if (mesh.positions[a].x() > 8 && mesh.positions[b].x() > 8 && mesh.positions[c].x() > 8)
        mesh.triangles.push_back({a + count, b + count, c + count});
    }
    expect_seen(mesh, 0.03, seed);
  }
}

// Where facets have been lost, the corners of others may meet at different heights: of those but
// one keeps its place.
TEST(ScanLayers, FacetsThatMeetInOnePointAtTwoHeights) {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 1}, {3, 0, 1}, {3, 3, 1}, {3, 3, 2}, {6, 3, 3},
                    {6, 6, 2}, {3, 6, 2}, {3, 3, 0}, {0, 6, 0}, {0, 3, 0}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}, {3, 5, 6}, {7, 8, 9}};
  constexpr double kLean = 0.01;
  const ScannedSurface scan = scan_of(mesh);
  const ScanSheet sheet = top_sheet(scan, scan.plan_box(), kLean, 1);
  EXPECT_EQ(sheet.unproven_area, 0);
  EXPECT_LE(sheet.moved, 2 * kLean);
  ASSERT_EQ(sheet.triangles.size(), 4U);
  EXPECT_EQ(sheet.points.size(), 10U);
  double down = 0;
  EXPECT_NEAR(area_of(sheet, down), 4.5 + 9 + 4.5, 0.2 * kLean * 36);
  EXPECT_EQ(down, 0);
  int at_place = 0;
  for (const Vec3& p : sheet.points) {
    const double away = (p.head<2>() - Vec2(3, 3)).norm();
    at_place += away == 0;
    EXPECT_TRUE(away == 0 || (away > 0.1 * kLean && away <= kLean) || away > 1) << away;
    if (away == 0) {
      EXPECT_EQ(p.z(), 2);
    }
  }
  EXPECT_EQ(at_place, 1);
}

// Each facet by itself, its corners a little off.
TriangleMesh cracked(const TriangleMesh& given, double off) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> part(-off, off);
  TriangleMesh mesh;
  for (const auto& t : given.triangles) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const std::uint32_t v : t) {
      mesh.positions.push_back(given.positions[v] + Vec3(part(random), part(random), part(random)));
    }
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

TEST(ScanCracks, AreClosedAndTheBorderLaidOnTheDomainsSides) {
  const TriangleMesh whole = shaken_relief(12, 3);
  const PlanBox domain{-7, 33, 2, 42};
  EXPECT_FALSE(close_cracks(scan_of(whole), domain, 1e-5, 1e-5));
  const std::optional<ClosedScan> made =
      close_cracks(scan_of(cracked(whole, 1e-6)), domain, 1e-5, 1e-4);
  ASSERT_TRUE(made);
  EXPECT_EQ(made->mesh.positions.size(), whole.positions.size());
  EXPECT_EQ(made->mesh.triangles.size(), whole.triangles.size());
  EXPECT_GT(made->moved, 1e-7);
  EXPECT_LT(made->moved, 1e-5);
  const PlanBox box = scan_of(made->mesh).plan_box();
  for (const auto& [at, side] : {std::pair{box.x0, domain.x0},
                                 {box.x1, domain.x1},
                                 {box.y0, domain.y0},
                                 {box.y1, domain.y1}})
    EXPECT_EQ(at, side);
  // Too narrow: they stay, but for facets that are all by themselves.
  const ScannedSurface wide = scan_of(cracked(whole, 1e-3));
  EXPECT_FALSE(close_cracks(wide, domain, 1e-9, 1e-9));
  for (const double width : {1e-9, 1e-3}) {  // closed in part first
    const std::optional<ClosedScan> loose = close_cracks(wide, domain, width, 1e-2);
    ASSERT_TRUE(loose);
    EXPECT_EQ(loose->mesh.positions.size(), whole.positions.size());
  }
  TriangleMesh partly = cracked(whole, 1e-3);
  for (const Vec3& p : whole.positions) partly.positions.push_back(p + Vec3(100, 0, 0));
  const auto more = static_cast<std::uint32_t>(partly.positions.size() - whole.positions.size());
  for (int copy = 0; copy < 2; ++copy) {
    for (const auto& t : whole.triangles)
      partly.triangles.push_back({t[0] + more, t[1] + more, t[2] + more});
  }
  EXPECT_FALSE(close_cracks(scan_of(partly), domain, 1e-9, 1e-2));
}

// Corners of one facet become one no more than others: it is left out.
TEST(ScanCracks, FacetsNarrowerThanACrackAreLeftOut) {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {10, 0, 0}, {0, 10, 0}, {10, 1e-6, 0}};
  mesh.triangles = {{0, 1, 2}, {1, 3, 2}};
  const std::optional<ClosedScan> made = close_cracks(scan_of(mesh), {-5, 20, -5, 20}, 1e-5, 1e-5);
  ASSERT_TRUE(made);
  EXPECT_EQ(made->mesh.triangles.size(), 1U);
  EXPECT_EQ(made->mesh.positions.size(), 3U);
}

}  // namespace
}  // namespace diesink::test
