// A scan as the base of a die: placed, with normals, holes filled, solids on it.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "core/base/scanned.h"
#include "core/compound/compound_surface.h"
#include "core/grid/grid_array.h"
#include "core/parallel.h"
#include "tests/support/height_mesh.h"
#include "tests/support/load_part.h"
#include "tests/support/scans.h"

namespace diesink {
namespace {

using test::scan_of;
using test::shaken_relief;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

TEST(Scanned, PlacementInTheOrderOfItsSteps) {
  TriangleMesh mesh;
  mesh.positions = {Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(0, 1, 0)};
  mesh.triangles = {{0, 1, 2}};
  using Kind = MeshPlacement::Kind;
  MeshBase base;
  base.placement = {{Kind::kScale, Vec3(2, 0, 0)},
                    {Kind::kMove, Vec3(1, 0, 5)},
                    {Kind::kRotateZ, Vec3(90, 0, 0)},
                    {Kind::kRotateX, Vec3(180, 0, 0)}};
  const ScannedSurface scan = scan_of(mesh, base);
  // (2, 0, 0) -> (4, 0, 0) -> (5, 0, 5) -> (0, 5, 5) -> (0, -5, -5)
  EXPECT_EQ(scan.positions()[0], Vec3(0, -1, -5));
  EXPECT_EQ(scan.positions()[1], Vec3(0, -5, -5));
  EXPECT_EQ(scan.positions()[2], Vec3(-2, -1, -5));
  BaseHit hit;
  ASSERT_TRUE(scan.at(-0.5, -2, hit));
  EXPECT_EQ(hit.z, -5);
}

TEST(Scanned, SmoothNormalsAreThoseOfTheSphere) {
  const double r = 20;
  TriangleMesh mesh = test::height_mesh(-10, 10, 80, -10, 10, 80, [&](double x, double y) {
    return std::sqrt(r * r - x * x - y * y);
  });
  MeshBase base;
  base.smooth_normals = true;
  const ScannedSurface smooth = scan_of(mesh, base), flat = scan_of(mesh);
  double worst_smooth = 0, worst_flat = 0;
  for (double x = -9.03; x < 9; x += 0.31) {
    for (double y = -9.01; y < 9; y += 0.37) {
      BaseHit hit;
      ASSERT_TRUE(smooth.at(x, y, hit));
      const Vec3 truth = Vec3(x, y, hit.z).normalized();
      worst_smooth = std::fmax(worst_smooth, (smooth.normal(hit.face, x, y) - truth).norm());
      worst_flat = std::fmax(worst_flat, (flat.normal(hit.face, x, y) - truth).norm());
    }
  }
  EXPECT_LT(worst_smooth, 0.002);
  EXPECT_GT(worst_flat, 0.005);
  // A file that repeats the vertices for each facet is no less smooth.
  TriangleMesh apart;
  for (const auto& t : mesh.triangles) {
    const auto v = static_cast<std::uint32_t>(apart.positions.size());
    for (const std::uint32_t corner : t) apart.positions.push_back(mesh.positions[corner]);
    apart.triangles.push_back({v, v + 1, v + 2});
  }
  const ScannedSurface repeated = scan_of(apart, base);
  for (double x = -9.03; x < 9; x += 0.7) {
    BaseHit hit;
    ASSERT_TRUE(smooth.at(x, 1.3, hit));
    ASSERT_EQ(repeated.normal(hit.face, x, 1.3), smooth.normal(hit.face, x, 1.3));
  }
}

// A hilly sheet with its triangles in a disk left out, but for those in an inner one.
template <class Height>
TriangleMesh holed_sheet(double radius, double island, const Height& height) {
  TriangleMesh mesh = test::height_mesh(-10, 10, 81, -10, 10, 81, height);
  std::erase_if(mesh.triangles, [&](const auto& t) {
    const Vec3 m = (mesh.positions[t[0]] + mesh.positions[t[1]] + mesh.positions[t[2]]) / 3;
    const double r = std::hypot(m.x() - 1.03, m.y() + 0.57);
    return r < radius && r > island;
  });
  return mesh;
}

TEST(Scanned, FillGoesOnWithWhatIsAround) {
  const double r = 20;
  const auto plane = [](double x, double y) { return 3 + 0.25 * x - 0.5 * y; };
  const auto sphere = [&](double x, double y) { return std::sqrt(r * r - x * x - y * y); };
  const auto saddle = [](double x, double y) { return 0.02 * x * x - 0.03 * y * y + 0.01 * x * y; };
  MeshBase base;
  base.fill_size = 6.5;
  const auto worst = [&](const ScannedSurface& scan, const auto& height) {
    double most = 0;
    for (double x = -9.9; x < 9.9; x += 0.093) {
      for (double y = -9.9; y < 9.9; y += 0.097) {
        BaseHit hit;
        EXPECT_TRUE(scan.at(x, y, hit));
        most = std::fmax(most, std::fabs(hit.z - height(x, y)));
      }
    }
    return most;
  };
  for (const double island : {0.0, 1.1}) {
    const TriangleMesh holed = holed_sheet(3, island, plane);
    const std::size_t given = holed.triangles.size();
    const ScannedSurface flat = scan_of(holed, base);
    EXPECT_EQ(flat.fill().holes, 1U);
    EXPECT_EQ(flat.triangles().size(), given + flat.fill().triangles);
    const double missing = (80 * 80 * 2 - static_cast<double>(given)) * 0.25 * 0.25 / 2;
    EXPECT_NEAR(flat.fill().area, missing, 1e-9);
    EXPECT_LT(worst(flat, plane), 1e-9);
    // A lid would lie 0.22 below the sphere's top.
    EXPECT_LT(worst(scan_of(holed_sheet(3, island, sphere), base), sphere), 0.006);
    EXPECT_LT(worst(scan_of(holed_sheet(3, island, saddle), base), saddle), 0.006);
  }
}

TEST(Scanned, FillLeavesLargerHolesAndTheOuterBorder) {
  const auto height = [](double x, double y) { return 0.1 * x * y; };
  const TriangleMesh mesh = holed_sheet(3, 0, height);
  MeshBase base;
  base.fill_size = 5.5;
  const ScannedSurface open = scan_of(mesh, base);
  EXPECT_EQ(open.fill().holes, 0U);
  EXPECT_EQ(open.triangles().size(), mesh.triangles.size());
  // The size is that of the placed scan.
  base.placement = {{MeshPlacement::Kind::kScale, Vec3(0.5, 0, 0)}};
  EXPECT_EQ(scan_of(mesh, base).fill().holes, 1U);
  // Facets that share no vertices, turned at random, are the same scan.
  TriangleMesh soup;
  std::mt19937 random(1);
  for (auto t : mesh.triangles) {
    if (random() % 2 == 0) std::swap(t[0], t[1]);
    const auto v = static_cast<std::uint32_t>(soup.positions.size());
    for (const std::uint32_t corner : t) soup.positions.push_back(mesh.positions[corner]);
    soup.triangles.push_back({v, v + 1, v + 2});
  }
  base.placement.clear();
  base.fill_size = 1000;
  const ScannedSurface closed = scan_of(soup, base);
  EXPECT_EQ(closed.fill().holes, 1U);
  const ScannedSurface shared = scan_of(mesh, base);
  EXPECT_EQ(closed.fill().triangles, shared.fill().triangles);
  BaseHit hit;
  EXPECT_FALSE(closed.at(10.01, 0, hit));
  // Two holes that touch in a vertex are two.
  TriangleMesh two = test::height_mesh(0, 6, 7, 0, 6, 7, height);
  std::erase_if(two.triangles, [&](const auto& t) {
    const Vec3 m = (two.positions[t[0]] + two.positions[t[1]] + two.positions[t[2]]) / 3;
    return (m.x() > 1 && m.x() < 2 && m.y() > 1 && m.y() < 2) ||
           (m.x() > 2 && m.x() < 4 && m.y() > 2 && m.y() < 4);
  });
  base.fill_size = 1.5;
  EXPECT_EQ(scan_of(two, base).fill().holes, 1U);
  base.fill_size = 3;
  EXPECT_EQ(scan_of(two, base).fill().holes, 2U);
}

TEST(Scanned, WhatCannotBeABaseIsRefused) {
  TriangleMesh mesh;
  EXPECT_FALSE(ScannedSurface::make(mesh, {}));
  mesh.positions = {Vec3(0, 0, 0), Vec3(1, 1, 0), Vec3(2, 2, 1)};
  mesh.triangles = {{0, 1, 2}};
  EXPECT_FALSE(ScannedSurface::make(mesh, {}));
  mesh.positions[2] = Vec3(0, kNaN, 0);
  EXPECT_FALSE(ScannedSurface::make(mesh, {}));
  mesh.positions[2] = Vec3(0, 2e9, 0);
  EXPECT_FALSE(ScannedSurface::make(mesh, {}));
  mesh.positions[2] = Vec3(0, 2, 0);
  EXPECT_TRUE(ScannedSurface::make(mesh, {}));
}

TEST(Scanned, CompoundSurfaceOnAScan) {
  const char* const text =
      "SOLID-DEF\nS1,SPHER,1\nP1,10,20,0\nRAD,6\nBSURF-DEF\nMESH,scan.stl\nBOOLE-DEF\nB+S1\n";
  const PartProgram program = test::program_of(text, "scan");
  EXPECT_FALSE(CompoundSurface::make(program));
  const TriangleMesh mesh = shaken_relief(40, 6);
  Result<CompoundSurface> surface = CompoundSurface::make(program, mesh);
  ASSERT_TRUE(surface);
  // What the program leaves open is the plan of the scan.
  const Machining& m = surface->program().machining;
  EXPECT_EQ(m.x_range, (std::array<double, 2>{-7, 33}));
  EXPECT_EQ(m.y_range, (std::array<double, 2>{2, 42}));
  EXPECT_DOUBLE_EQ(m.x_interval, 0.4);
  const Result<GridArray> grid = evaluate_grid(*surface, 0);
  ASSERT_TRUE(grid);
  const ScannedSurface scan = scan_of(mesh);
  int of_base = 0;
  for (std::size_t k = 0; k < grid->size(); ++k) {
    const double x = grid->x()[k % grid->columns()], y = grid->y()[k / grid->columns()];
    const std::optional<CcDatum> row = grid->at(*surface, k), point = surface->at(x, y);
    ASSERT_TRUE(row && point);
    ASSERT_EQ(row->z, point->z);
    ASSERT_EQ(row->surface, point->surface);
    ASSERT_NEAR((row->n - point->n).norm(), 0, row->surface == 0 ? 0 : 1e-15);
    BaseHit hit;
    ASSERT_TRUE(scan.at(x, y, hit));
    const double rest = 36 - (x - 10) * (x - 10) - (y - 20) * (y - 20);
    const double ball = rest >= 0 ? std::sqrt(rest) : -1e9;
    ASSERT_NEAR(row->z, std::fmax(hit.z, ball), 1e-6);
    of_base += row->surface == 0 ? 1 : 0;
  }
  EXPECT_GT(of_base, 1000);
  EXPECT_LT(of_base, static_cast<int>(grid->size()) - 100);
}

TEST(Scanned, GridsOfACompoundSurfaceHaveTheDigitsOfItsPoints) {
  // Drawn as a whole, and row by row where few of the triangles are met; with the scan first,
  // later, in a group or not at all, with smooth normals.
  for (const char* const expression : {"B+S1-S2", "S1+B-S2", "S2+(B-S1)", "S1+S2"}) {
    for (const char* const smooth : {"", "NORMALS,SMOOTH\n"}) {
      const std::string text =
          std::string(
              "SOLID-DEF\nS1,SPHER,1\nP1,10,20,0\nRAD,6\nS2,SPHER,1\nP1,16,24,3\nRAD,5\n"
              "BSURF-DEF\nMESH,scan.stl\n") +
          smooth + "BOOLE-DEF\n" + expression + "\n";
      const Result<CompoundSurface> surface =
          CompoundSurface::make(test::program_of(text, "scan"), shaken_relief(80, 6));
      ASSERT_TRUE(surface);
      for (const double interval : {0.37, 9.0}) {
        Result<GridArray> grid =
            evaluate_grid(*surface, grid_lines(-9, 35, interval), grid_lines(0, 43, interval), 2);
        ASSERT_TRUE(grid);
        std::size_t there = 0;
        for (std::size_t k = 0; k < grid->size(); ++k) {
          const std::optional<CcDatum> a = grid->at(*surface, k),
                                       b = surface->at(grid->x()[k % grid->columns()],
                                                       grid->y()[k / grid->columns()]);
          ASSERT_EQ(a.has_value(), b.has_value()) << expression << ' ' << k;
          if (!a) {
            ASSERT_EQ(grid->row(0).nz[k], 0);
            continue;
          }
          ++there;
          ASSERT_EQ(a->z, b->z);
          ASSERT_EQ(a->row, b->row);
          ASSERT_NEAR((a->n - b->n).norm(), 0, a->surface == 0 ? 0 : 1e-15);
        }
        if (interval < 1) {
          EXPECT_GT(there, 500U);
        }
      }
    }
  }
}

}  // namespace
}  // namespace diesink
