// The paper's method: step length, CL-data, interferences.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "core/machining/cc_pass.h"
#include "core/machining/interference.h"
#include "core/part_program/part_program.h"
#include "tests/support/height_mesh.h"

namespace diesink {
namespace {

using test::height_mesh;

CompoundSurface surface_of(const std::string& text) {
  Diagnostics diagnostics;
  const auto program = parse_part_program(text, "test.part", diagnostics);
  EXPECT_TRUE(program.has_value());
  Result<CompoundSurface> made = CompoundSurface::make(*program);
  return std::move(made.value());
}

// A dome on a plane: a concave edge all round it.
CompoundSurface dome() {
  return surface_of(
      "SOLID-DEF\nS1,SPHER,1\nP1,15,10,-3\nRAD,8\nBSURF-DEF\nPLANE,0\nBOOLE-DEF\nB+S1\nMACHI-DEF\n"
      "X-RNG,0,30\nY-RNG,0,20\n");
}

TriangleMesh mesh_of(const CompoundSurface& surface) {
  return height_mesh(-4, 34, 381, -4, 24, 281,
                     [&](double x, double y) { return surface.at(x, y)->z; });
}

TEST(CuttingError, IsTheSagOfTheOffsetArc) {
  // A circle of radius 10 in the plane of the pass, angles 20 and 24 degrees from the top.
  const auto on = [](double degrees, double rho, double side) {
    const double a = degrees * M_PI / 180;
    const Vec3 n(std::sin(a) * side, 0, std::cos(a));
    return CcContact{Vec3(rho * std::sin(a), 0, side * rho * std::cos(a)), n};
  };
  const double sag = 1 - std::cos(2 * M_PI / 180);
  EXPECT_NEAR(cutting_error(on(20, 10, 1), on(24, 10, 1), Vec2(1, 0), 3), 13 * sag, 1e-12);
  EXPECT_NEAR(cutting_error(on(20, 10, -1), on(24, 10, -1), Vec2(1, 0), 3), -7 * sag, 1e-12);
  EXPECT_EQ(cutting_error(on(20, 10, 1), on(20, 10, 1), Vec2(1, 0), 3), 0);
}

TEST(CcPass, KeepsTheStepAndFindsTheEdges) {
  const CompoundSurface surface = dome();
  const PlanCurve line = [](double s) { return Vec2(30 * s, 10); };
  const auto stretches = cc_pass(surface, line, 3, 1.5, 0.01, 0.01);
  ASSERT_EQ(stretches.size(), 1u);
  const std::vector<CcSample>& run = stretches[0];
  EXPECT_EQ(run.front().contact.p.x(), 0);
  EXPECT_EQ(run.back().contact.p.x(), 30);
  std::size_t edges = 0;
  const double half = std::sqrt(64 - 9.0);
  for (std::size_t k = 1; k < run.size(); ++k) {
    EXPECT_GT(run[k].s, run[k - 1].s);
    if (run[k].after_edge) {
      ++edges;
      EXPECT_NE(run[k].row, run[k - 1].row);
      EXPECT_NEAR(std::fabs(run[k].contact.p.x() - 15), half, 1e-9);
      EXPECT_NEAR(run[k].contact.p.x(), run[k - 1].contact.p.x(), 1e-9);
      continue;
    }
    EXPECT_LE(std::fabs(cutting_error(run[k - 1].contact, run[k].contact, Vec2(1, 0), 3)), 0.01);
  }
  EXPECT_EQ(edges, 2u);
}

TEST(CcPass, HolesDivideIt) {
  const CompoundSurface surface = surface_of(
      "SOLID-DEF\nS1,SPHER,1\nP1,5,5,0\nRAD,3\nS2,SPHER,1\nP1,15,5,0\nRAD,3\nBOOLE-DEF\n+S1+S2\n"
      "MACHI-DEF\nX-RNG,0,20\nY-RNG,0,10\n");
  const auto stretches = cc_pass(
      surface, [](double s) { return Vec2(20 * s, 5); }, 2, 1, 0.01, 0.01);
  ASSERT_EQ(stretches.size(), 2u);
  EXPECT_NEAR(stretches[0].front().contact.p.x(), 2, 1e-9);
  EXPECT_NEAR(stretches[1].back().contact.p.x(), 18, 1e-9);
}

TEST(Interference, LoopsAtConcaveEdgesAreCutOutAndCrossingsPutIn) {
  const CompoundSurface surface = dome();
  const TriangleMesh mesh = mesh_of(surface);
  const CutterShape cutter = CutterShape::make({6, 3}).value();
  const OffsetSurface offset(mesh, cutter, 0);
  const PointDrop drop(offset);
  const auto stretches = cc_pass(
      surface, [](double s) { return Vec2(30 * s, 10); }, 3, 0.4, 0.01, 0.01);
  const std::vector<Vec3> raw = tips_of(cutter, stretches[0], 0.01);
  const auto deepest = [&](const std::vector<Vec3>& tips) {
    double depth = 0;
    for (std::size_t k = 1; k < tips.size(); ++k) {
      for (int s = 0; s <= 10; ++s) {
        const Vec3 p = tips[k - 1] + (tips[k] - tips[k - 1]) * s / 10.0;
        depth = std::fmax(depth, drop.at(p.x(), p.y()) - p.z());
      }
    }
    return depth;
  };
  EXPECT_GT(deepest(raw), 0.5);
  InterferenceCounts counts;
  SegmentProfile profile(offset, drop, 0.001);
  std::vector<Vec3> clean = raw;
  const double bound = without_interference(clean, drop, profile, 0.02, counts);
  EXPECT_LE(bound, 0.02);
  EXPECT_LE(deepest(clean), bound + 1e-12);
  EXPECT_LE(deepest(clean), 0.02);
  EXPECT_EQ(counts.loops, 2u);
  EXPECT_GE(counts.crossings, 2u);
  // Fig. 12, point C: the ball touches plane and dome at once.
  const double reach = std::sqrt((8 + 3.0) * (8 + 3) - (3 + 3.0) * (3 + 3));
  double nearest = 1e9;
  for (const Vec3& p : clean) {
    nearest = std::fmin(nearest, (p - Vec3(15 - reach, 10, 0)).norm());
  }
  EXPECT_LE(nearest, 0.02);
  for (std::size_t k = 1; k < clean.size(); ++k) EXPECT_GE(clean[k].x(), clean[k - 1].x() - 1e-9);
}

TEST(PlanCc, WholePathKeepsOffTheSurface) {
  const CompoundSurface surface = dome();
  const TriangleMesh mesh = mesh_of(surface);
  PathOptions options;
  options.cutter = {6, 3};
  options.method = PathMethod::kCc;
  options.cusp = 0.05;
  options.intol = options.outtol = 0.02;
  const Result<PlannedPath> planned = plan_cc_path(surface, mesh, 0, options);
  ASSERT_TRUE(planned) << planned.error().message;
  EXPECT_GT(planned->report.loops_removed, 10u);
  EXPECT_GT(planned->report.passes, 20u);
  EXPECT_EQ(planned->cc_passes.size(), planned->report.passes);
  const CutterShape cutter = CutterShape::make(options.cutter).value();
  const OffsetSurface offset(mesh, cutter, 0);
  const PointDrop drop(offset);
  for (const ClPoint& point : planned->path.points) {
    EXPECT_LE(drop.at(point.tip.x(), point.tip.y()) - point.tip.z(), 0.02 + 1e-9);
  }
  // Left in, the loops gouge.
  options.keep_interference = true;
  const Result<PlannedPath> raw = plan_cc_path(surface, mesh, 0, options);
  double deepest = 0;
  for (const ClPoint& point : raw->path.points) {
    deepest = std::fmax(deepest, drop.at(point.tip.x(), point.tip.y()) - point.tip.z());
  }
  EXPECT_GT(deepest, 0.5);
  // Curves of a base need one.
  options.along = PathAlong::kU;
  const Result<PlannedPath> none = plan_cc_path(surface, mesh, 0, options);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, ErrorCode::kInput);
}

TEST(PlanCc, FollowsIsoparametricCurves) {
  std::string base = "BSURF-DEF\n4,3\n";
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 4; ++i) {
      base += std::to_string(10 * i + 2 * j) + "," + std::to_string(10 * j + i) + "," +
              std::to_string((i * j) % 3) + "\n";
    }
  }
  const CompoundSurface surface =
      surface_of(base + "BOOLE-DEF\nB\nMACHI-DEF\nX-RNG,0,30\nY-RNG,0,20\n");
  const TriangleMesh mesh = height_mesh(0, 34, 171, 0, 23, 116, [&](double x, double y) {
    const auto d = surface.at(x, y);
    return d ? d->z : std::nan("");
  });
  PathOptions options;
  options.cutter = {4, 2};
  options.method = PathMethod::kCc;
  options.along = PathAlong::kU;
  options.interval = 2;
  options.intol = options.outtol = 0.05;
  const Result<PlannedPath> planned = plan_cc_path(surface, mesh, 0.02, options);
  ASSERT_TRUE(planned) << planned.error().message;
  EXPECT_GE(planned->report.passes, 8u);
  // Along u the grid's rows rise by one in ten: so do the passes in plan.
  std::size_t seen = 0;
  for (const auto& pass : planned->cc_passes) {
    if (pass.size() < 2) continue;
    const Vec3 d = pass.back().p - pass.front().p;
    EXPECT_NEAR(d.y() / d.x(), 0.1, 0.02);
    ++seen;
  }
  EXPECT_GE(seen, 8u);
}

}  // namespace
}  // namespace diesink
