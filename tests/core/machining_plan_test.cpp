// Passes, their fit and the planned path, checked by dense drops between the points.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/machining/drop.h"
#include "core/machining/pass_profile.h"
#include "core/machining/path_fit.h"
#include "core/machining/path_interval.h"
#include "core/machining/tool_path_plan.h"
#include "tests/support/height_mesh.h"
#include "tests/support/random_program.h"

namespace diesink {
namespace {

using test::height_mesh;
using test::Random;

// Hills, a valley with a sharp bottom, a ridge and an upright step.
double relief(double x, double y) {
  const double hills = 1.5 * std::sin(0.5 * x) * std::cos(0.4 * y);
  const double valley = std::fabs(x - 14) < 3 ? -(3 - std::fabs(x - 14)) : 0;
  const double ridge = std::fabs(y - 6) < 2 ? 2 - std::fabs(y - 6) : 0;
  return hills + valley + ridge + (x + 0.3 * y > 25 ? 4 : 0);
}

TriangleMesh relief_mesh() { return height_mesh(-4, 34, 77, -4, 24, 57, relief); }

PathOptions options_of(double diameter, double corner) {
  PathOptions options;
  options.cutter = {diameter, corner};
  options.interval = 1.5;
  options.intol = options.outtol = 0.02;
  options.threads = 1;
  return options;
}

TEST(UpperEnvelope, IsTheLargestEverywhere) {
  Random random(5);
  for (int round = 0; round < 200; ++round) {
    std::vector<ProfileSegment> segments;
    const int n = 1 + random.below(40);
    for (int k = 0; k < n; ++k) {
      const double x0 = random.uniform(0, 10), width = random.uniform(0.01, 4);
      segments.push_back({x0, random.uniform(0, 3), x0 + width, random.uniform(0, 3),
                          static_cast<std::uint32_t>(k)});
    }
    std::vector<ProfileSegment> envelope = segments;
    UpperEnvelope().take(envelope);
    for (std::size_t k = 1; k < envelope.size(); ++k) {
      EXPECT_LE(envelope[k - 1].x1, envelope[k].x0);
    }
    const auto height = [](const std::vector<ProfileSegment>& all, double x) {
      double z = kNoContact;
      for (const ProfileSegment& s : all) {
        if (x < s.x0 || x > s.x1) continue;
        z = std::fmax(z, s.z0 + (x - s.x0) / (s.x1 - s.x0) * (s.z1 - s.z0));
      }
      return z;
    };
    for (int k = 0; k < 200; ++k) {
      const double x = random.uniform(-0.5, 14.5);
      const double expected = height(segments, x), found = height(envelope, x);
      if (expected == kNoContact)
        EXPECT_EQ(found, expected);
      else
        EXPECT_NEAR(found, expected, 1e-11);
    }
  }
}

TEST(FitRuns, FewPointsOnFlatsAndEveryCorner) {
  const std::vector<ProfileSegment> profile{{0, 0, 4, 0, 0},      {4, 0, 5, 0.0001, 1},
                                            {5, 0.0001, 8, 0, 2},  // flat to the tolerance
                                            {8, 0, 10, 2, 3},      // sharp concave corner
                                            {10, 5, 12, 5, 4},     // step
                                            {13, 1, 14, 1, 5}};    // after a gap
  const std::vector<PassRun> runs = fit_runs(profile, 0.001, 0.001, 1e-6);
  ASSERT_EQ(runs.size(), 2u);
  const PassRun expected{{0, 0}, {8, 0}, {10, 2}, {10, 5}, {12, 5}};
  EXPECT_EQ(runs[0], expected);
  EXPECT_EQ(runs[1], (PassRun{{13, 1}, {14, 1}}));
}

TEST(FitRuns, ASlitOfRoundingIsNoStep) {
  const double after = std::nextafter(4.0, 5.0);
  const std::vector<ProfileSegment> profile{
      {0, 2, 4, 3, 0}, {4, 0, after, 0, 1}, {after, 3, 8, 2, 2}};
  const std::vector<PassRun> runs = fit_runs(profile, 0.001, 0.001, 1e-6);
  ASSERT_EQ(runs.size(), 1u);
  EXPECT_EQ(runs[0], (PassRun{{0, 2}, {4, 3}, {8, 2}}));
}

TEST(CuspInterval, LeavesTheCusp) {
  // Two circles of the cutter on a circle of the surface: the height of their crossing, by plain
  // geometry.
  for (const double R : {3.0, 6.0}) {
    for (const double rho : {1e7, 40.0, 8.0, -12.0, -40.0}) {
      for (const double h : {0.002, 0.05}) {
        const double l = cusp_interval(R, 1 / rho, h);
        const double half = std::asin(l / 2 / std::fabs(rho));  // at the centre of curvature
        const double d = std::fabs(R + rho);                    // centres from there
        // Crossing of the two circles on the middle line, on the surface's side.
        const double along = d * std::cos(half), across = d * std::sin(half);
        const double root = std::sqrt(R * R - across * across);
        const double crossing = rho > 0 ? along - root : along + root;
        EXPECT_NEAR(std::fabs(crossing - std::fabs(rho)), h, 2e-8 * std::fabs(rho) / 10 + 1e-9)
            << R << " " << rho << " " << h;
      }
    }
    EXPECT_DOUBLE_EQ(cusp_interval(R, 0, 0.01), 2 * std::sqrt(0.01 * (2 * R - 0.01)));
  }
}

TEST(CuspInterval, PlanIntervalOfASlope) {
  // Sloping 30 degrees across the pass: (17) gives the cosine; along the pass it gives 1.
  const Vec3 n(0, -0.5, std::sqrt(0.75));
  EXPECT_NEAR(plan_interval(1, n, Vec2(1, 0)), std::sqrt(0.75), 1e-15);
  EXPECT_NEAR(plan_interval(1, n, Vec2(0, 1)), 1, 1e-15);
  const CutterShape ball = CutterShape::make({6, 3}).value();
  EXPECT_NEAR(drop_interval(ball, n, Vec2(1, 0), 0, 0.01),
              cusp_interval(3, 0, 0.01) * std::sqrt(0.75), 1e-14);
}

// The tip's height between the points of every cutting move against an independent drop.
void check_path(const TriangleMesh& mesh, const PathOptions& options, const PlannedPath& planned) {
  const CutterShape cutter = CutterShape::make(options.cutter).value();
  const OffsetSurface offset(mesh, cutter, 0);
  const PointDrop drop(offset);
  const auto& points = planned.path.points;
  ASSERT_GT(points.size(), 10u);
  // First and last safe; down only at feed; across at rapid only on the clearance plane.
  EXPECT_EQ(points.front().motion, Motion::kRapid);
  EXPECT_EQ(points.front().tip.z(), planned.path.clearance);
  EXPECT_EQ(points.back().motion, Motion::kRapid);
  EXPECT_EQ(points.back().tip.z(), planned.path.clearance);
  double deepest = -1, highest = -1;
  for (std::size_t k = 1; k < points.size(); ++k) {
    const Vec3 a = points[k - 1].tip, b = points[k].tip;
    if (points[k].motion == Motion::kRapid) {
      EXPECT_GE(b.z(), a.z());
      if ((a - b).head<2>().norm() > 1e-12) {
        EXPECT_EQ(a.z(), b.z());
      }
      EXPECT_EQ(b.z(), planned.path.clearance);
      continue;
    }
    for (int s = 0; s <= 12; ++s) {
      const Vec3 p = a + (b - a) * s / 12.0;
      // Straight up beside an upright wall the side of the cutter touches: a hair away counts too.
      constexpr double kHair = 1e-8;
      const double lowest =
          std::fmin(drop.at(p.x(), p.y()),
                    std::fmin(drop.at(p.x() - kHair, p.y()), drop.at(p.x() + kHair, p.y())));
      if (lowest == kNoContact) continue;
      deepest = std::fmax(deepest, lowest - p.z());
      if (s > 0 && s < 12 && std::fabs(b.x() - a.x()) > 1e-9 && std::fabs(b.y() - a.y()) < 1e-9) {
        highest = std::fmax(highest, p.z() - lowest);
      }
    }
  }
  EXPECT_LE(deepest, planned.report.overcut_bound + 1e-9);
  EXPECT_LE(planned.report.overcut_bound, options.intol + 1e-12);
  // Moves along x that are no links keep the outside tolerance too.
  if (options.angle == 0 && options.pattern == PathPattern::kOneway) {
    EXPECT_LE(highest, options.outtol + 1e-9);
  }
}

TEST(PlanDrop, NeitherGougesNorLeavesBetweenPoints) {
  const TriangleMesh mesh = relief_mesh();
  for (const auto& [diameter, corner] : {std::pair{6.0, 3.0}, {6.0, 1.0}, {6.0, 0.0}}) {
    for (const PathPattern pattern : {PathPattern::kZigzag, PathPattern::kOneway}) {
      PathOptions options = options_of(diameter, corner);
      options.pattern = pattern;
      const Result<PlannedPath> planned = plan_drop_path(mesh, 0, {0, 30, 0, 20}, options);
      ASSERT_TRUE(planned) << planned.error().message;
      check_path(mesh, options, *planned);
    }
  }
}

TEST(PlanDrop, OneSidedTolerancesAndMeshDeviation) {
  const TriangleMesh mesh = relief_mesh();
  for (const auto& [in, out] : {std::pair{0.0, 0.04}, {0.04, 0.0}, {0.001, 0.05}}) {
    PathOptions options = options_of(6, 3);
    options.intol = in;
    options.outtol = out;
    const double deviation = 0.004;
    const Result<PlannedPath> planned = plan_drop_path(mesh, deviation, {0, 30, 0, 20}, options);
    ASSERT_TRUE(planned) << planned.error().message;
    EXPECT_LE(planned->report.overcut_bound, in + 1e-12);
    EXPECT_LE(planned->report.undercut_bound, out + 1e-12);
  }
}

TEST(PlanDrop, AnyDirectionAndAnyThreads) {
  const TriangleMesh mesh = relief_mesh();
  for (const double angle : {std::numbers::pi / 2, 0.6, -1.0}) {
    PathOptions options = options_of(5, 2.5);
    options.angle = angle;
    options.interval.reset();
    options.cusp = 0.05;
    const Result<PlannedPath> one = plan_drop_path(mesh, 0, {0, 30, 0, 20}, options);
    ASSERT_TRUE(one) << one.error().message;
    check_path(mesh, options, *one);
    for (const ClPoint& point : one->path.points) {
      EXPECT_GT(point.tip.x(), -1e-9);
      EXPECT_LT(point.tip.x(), 30 + 1e-9);
      EXPECT_GT(point.tip.y(), -1e-9);
      EXPECT_LT(point.tip.y(), 20 + 1e-9);
    }
    options.threads = 7;
    const Result<PlannedPath> seven = plan_drop_path(mesh, 0, {0, 30, 0, 20}, options);
    ASSERT_EQ(one->path.points.size(), seven->path.points.size());
    for (std::size_t k = 0; k < one->path.points.size(); ++k) {
      EXPECT_EQ(one->path.points[k].tip, seven->path.points[k].tip);
    }
  }
}

TEST(PlanDrop, CuspSetsTheInterval) {
  const TriangleMesh level = height_mesh(-4, 24, 8, -4, 24, 8, [](double, double) { return 1.0; });
  PathOptions options = options_of(6, 3);
  options.interval.reset();
  options.cusp = 0.01;
  const Result<PlannedPath> planned = plan_drop_path(level, 0, {0, 20, 0, 20}, options);
  ASSERT_TRUE(planned);
  const double expected = 2 * std::sqrt(0.01 * (6 - 0.01));
  EXPECT_NEAR(planned->report.greatest_interval, expected, 1e-12);
  EXPECT_EQ(planned->report.passes, static_cast<std::size_t>(std::ceil(20 / expected)) + 1);
  // Two points a pass, two for the link between passes at most, three to come and go.
  EXPECT_LE(planned->report.points, planned->report.passes * 2 + 3);
}

TEST(PlanDrop, HolesAreCrossedOnTheClearancePlane) {
  const TriangleMesh mesh = height_mesh(0, 40, 41, 0, 10, 11, [](double x, double) {
    return x > 12.5 && x < 27.5 ? std::nan("") : 0.0;
  });
  const Result<PlannedPath> planned = plan_drop_path(mesh, 0, {0, 40, 0, 10}, options_of(4, 2));
  ASSERT_TRUE(planned);
  check_path(mesh, options_of(4, 2), *planned);
  std::size_t crossings = 0;
  const auto& points = planned->path.points;
  for (std::size_t k = 1; k < points.size(); ++k) {
    if (std::fabs(points[k].tip.x() - points[k - 1].tip.x()) > 8 &&
        points[k].motion == Motion::kRapid) {
      ++crossings;
    }
  }
  EXPECT_EQ(crossings, planned->report.passes);
}

TEST(PlanDrop, RapidMovesStandOverWhatIsLeft) {
  const TriangleMesh mesh = height_mesh(0, 40, 9, 0, 40, 9, [](double, double) { return 3.0; });
  PathOptions options = options_of(6, 3);
  options.outtol = 30;  // far more than the cutter's diameter
  const Result<PlannedPath> planned = plan_drop_path(mesh, 0, {0, 40, 0, 40}, options);
  ASSERT_TRUE(planned) << planned.error().message;
  for (const ClPoint& point : planned->path.points) {
    EXPECT_LE(point.tip.z(), planned->path.clearance);
  }
  options.clearance = 4;
  const Result<PlannedPath> low = plan_drop_path(mesh, 0, {0, 40, 0, 40}, options);
  ASSERT_FALSE(low);
  EXPECT_NE(low.error().message.find("left on it"), std::string::npos);
}

TEST(PlanDrop, RefusesWhatCannotBe) {
  const TriangleMesh mesh = height_mesh(0, 10, 4, 0, 10, 4, [](double, double) { return 3.0; });
  PathOptions options = options_of(6, 3);
  options.clearance = 2;
  EXPECT_FALSE(plan_drop_path(mesh, 0, {0, 10, 0, 10}, options));
  EXPECT_FALSE(plan_drop_path(mesh, 0.1, {0, 10, 0, 10}, options_of(6, 3)));
  EXPECT_FALSE(plan_drop_path(mesh, 0, {100, 110, 0, 10}, options_of(6, 3)));
}

}  // namespace
}  // namespace diesink
