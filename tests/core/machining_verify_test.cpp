// The verification against dense sampling, and its nose for errors that were put into a path.
// SPDX-License-Identifier: Apache-2.0
#include "core/machining/verify.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/machining/cell_bounds.h"
#include "core/machining/gouge_search.h"
#include "core/machining/swept_heights.h"
#include "core/machining/tool_path_plan.h"
#include "core/machining/wide_surface.h"
#include "core/part_program/part_program.h"
#include "core/tessellate/tessellate.h"
#include "tests/support/height_mesh.h"
#include "tests/support/load_part.h"
#include "tests/support/random_program.h"

namespace diesink {
namespace {

using test::height_mesh;
using test::Random;

CutterShape shape(double diameter, double corner) {
  return CutterShape::make({diameter, corner}).value();
}
constexpr double kCutters[][2] = {{6, 3}, {6, 0}, {6, 1.2}};

// Distance of a point inside a standing cutter to its outside, by the cutter's parts.
double inside(const CutterShape& c, const Vec3& p) {
  const double rho = p.head<2>().norm(), z = p.z(), r = c.corner();
  if (z < 0 || rho > c.radius()) return 0;
  double depth = std::fmin(z, c.radius() - rho);
  if (z < r && rho > c.flat()) depth = r - std::hypot(rho - c.flat(), r - z);
  return std::fmax(0, depth);
}

TEST(SweepDepth, MatchesSampling) {
  for (const auto& d : kCutters) {
    const CutterShape cutter = shape(d[0], d[1]);
    Random random(11);
    for (int round = 0; round < 60; ++round) {
      const auto point = [&](double spread) {
        return Vec3{random.uniform(-spread, spread), random.uniform(-spread, spread),
                    random.uniform(-2, 2)};
      };
      const Vec3 a = point(4), b = point(4), c = point(4);
      const Vec3 from{random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-3, 2)};
      // Standing still: the depth in the cutter itself, no move's end rounds it off.
      const SweepDepth still = sweep_depth(cutter, {from, from}, {a, b, c}, 0, 20);
      double deepest = 0;
      constexpr int kSteps = 150;
      for (int i = 0; i <= kSteps; ++i) {
        for (int j = 0; i + j <= kSteps; ++j) {
          const Vec3 p = a + (b - a) * i / kSteps + (c - a) * j / kSteps;
          deepest = std::fmax(deepest, inside(cutter, p - from));
        }
      }
      EXPECT_GE(still.bound, deepest - 1e-9);
      EXPECT_GE(still.found, deepest - 1e-7);
      EXPECT_LE(still.found, deepest + 0.05);
      EXPECT_LE(still.bound - still.found, 1e-6);
      // A sweep holds every position of the cutter.
      const Vec3 to = from + Vec3(3, -1, 0.5);
      const SweepDepth swept = sweep_depth(cutter, {from, to}, {a, b, c}, 0, 20);
      for (const double t : {0.0, 0.3, 1.0}) {
        const Vec3 at = from + t * (to - from);
        EXPECT_GE(swept.bound, sweep_depth(cutter, {at, at}, {a, b, c}, 0, 20).found - 1e-8);
      }
    }
  }
}

TEST(SweptHeights, MatchSampling) {
  for (const auto& d : kCutters) {
    const CutterShape cutter = shape(d[0], d[1]);
    Random random(12);
    for (int round = 0; round < 300; ++round) {
      const Vec3 from{random.uniform(-4, 4), random.uniform(-4, 4), random.uniform(-2, 2)};
      const bool upright = random.chance(0.1);
      const Vec3 to =
          upright ? Vec3{from.x(), from.y(), 3}
                  : Vec3{random.uniform(-4, 4), random.uniform(-4, 4), random.uniform(-2, 2)};
      const double x = random.uniform(-5, 5), y = random.uniform(-5, 5);
      double lowest = std::numeric_limits<double>::infinity();
      for (int k = 0; k <= 4000; ++k) {
        const Vec3 tip = from + (to - from) * k / 4000.0;
        const double rho = std::hypot(x - tip.x(), y - tip.y());
        if (rho <= cutter.radius()) lowest = std::fmin(lowest, tip.z() + cutter.height(rho));
      }
      const double found = swept_height(cutter, {from, to}, x, y);
      if (std::isinf(lowest)) continue;
      EXPECT_LE(found, lowest + 1e-12);
      EXPECT_GE(found, lowest - 0.1);  // the samples' own steps at a steep rim
    }
  }
}

TEST(SweptHeights, TilesHideNothing) {
  Random random(13);
  for (const auto& d : kCutters) {
    const CutterShape cutter = shape(d[0], d[1]);
    std::vector<SweepMove> moves;
    Vec3 at{0, 0, 1};
    for (int k = 0; k < 120; ++k) {
      const Vec3 to{random.uniform(0, 30), random.uniform(0, 20), random.uniform(0, 3)};
      moves.push_back({at, to});
      at = to;
    }
    const PlanLattice lattice{0, 0, 0.37, 0.41, 80, 49};
    const std::vector<double> part(lattice.columns * lattice.rows, 0.0);
    SweptHeights swept(cutter, lattice, part);
    swept.cut(std::span(moves).first(50), 2);
    swept.cut(std::span(moves).subspan(50), 2);
    const std::vector<double>& heights = swept.heights();
    for (std::size_t j = 0; j < lattice.rows; j += 3) {
      for (std::size_t i = 0; i < lattice.columns; i += 3) {
        double lowest = std::numeric_limits<double>::infinity();
        for (const SweepMove& m : moves) {
          lowest = std::fmin(lowest, swept_height(cutter, m, lattice.x(i), lattice.y(j)));
        }
        EXPECT_EQ(heights[j * lattice.columns + i], lowest);
        if (i + 1 == lattice.columns || j + 1 == lattice.rows) continue;
        // Nowhere in the cell more than it says.
        const double over = static_cast<double>(swept.over_cells()[j * lattice.columns + i]);
        if (std::isinf(over)) continue;
        for (int k = 0; k < 9; ++k) {
          const double x = lattice.x(i) + lattice.dx * (k % 3) / 2.0;
          const double y = lattice.y(j) + lattice.dy * (k / 3) / 2.0;
          double left = std::numeric_limits<double>::infinity();
          for (const SweepMove& m : moves) left = std::fmin(left, swept_height(cutter, m, x, y));
          EXPECT_LE(left, over + 1e-9);
        }
      }
    }
  }
}

TEST(GougeSearch, PassesNoTriangleOver) {
  for (const auto& d : kCutters) {
    const CutterShape cutter = shape(d[0], d[1]);
    Random random(14);
    for (int round = 0; round < 20; ++round) {
      // Small and large triangles, far from the origin, as single precision knows them badly.
      TriangleMesh mesh;
      const Vec3 place{random.uniform(-900, 900), random.uniform(-900, 900), 0};
      for (std::uint32_t t = 0; t < 150; ++t) {
        const double size = random.chance(0.1) ? 6 : 0.4;
        const Vec3 at =
            place + Vec3{random.uniform(0, 12), random.uniform(0, 9), random.uniform(0, 2)};
        for (int k = 0; k < 3; ++k) {
          mesh.positions.push_back(at + Vec3{random.uniform(-size, size),
                                             random.uniform(-size, size), random.uniform(-1, 0)});
        }
        mesh.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
      }
      for (int k = 0; k < 15; ++k) {
        const auto tip = [&] {
          return Vec3(place +
                      Vec3{random.uniform(-3, 15), random.uniform(-3, 12), random.uniform(0.5, 4)});
        };
        const SweepMove move{tip(), tip()};
        double deepest = 0;
        for (const auto& [a, b, c] : mesh.triangles) {
          deepest = std::fmax(
              deepest, sweep_depth(cutter, move,
                                   {mesh.positions[a], mesh.positions[b], mesh.positions[c]}, 0, 20)
                           .found);
        }
        GougeSearch search(mesh, cutter);
        search.add(std::span(&move, 1), 1);
        EXPECT_NEAR(search.deepest().depth, deepest, 1e-8);
      }
    }
  }
}

// A plane with a ball-shaped hill: paths for it are planned on its mesh.
struct Part {
  CompoundSurface surface;
  TriangleMesh mesh;
};

Part part() {
  Diagnostics diagnostics;
  const auto program = parse_part_program(
      "SOLID-DEF\nS1,SPHER,1\nP1,15,10,-6\nRAD,9\nBSURF-DEF\nPLANE,0\nBOOLE-DEF\nB+S1\nMACHI-DEF\n"
      "X-RNG,0,30\nY-RNG,0,20\n",
      "hill.part", diagnostics);
  Result<CompoundSurface> made = CompoundSurface::make(*program);
  CompoundSurface surface = std::move(made.value());
  TriangleMesh mesh = height_mesh(-4, 34, 381, -4, 24, 281,
                                  [&](double x, double y) { return surface.at(x, y)->z; });
  return {std::move(surface), std::move(mesh)};
}

PathOptions path_options() {
  PathOptions options;
  options.cutter = {6, 3};
  options.cusp = 0.02;
  options.intol = options.outtol = 0.02;
  return options;
}

VerifyOptions verify_options() {
  VerifyOptions options;
  options.cutter = {6, 3};
  options.intol = options.outtol = 0.02;
  options.cusp = 0.02;
  options.spacing = 0.15;
  options.threads = 2;
  return options;
}

// A roof whose ridge runs through the cells at a slant, cut along its ridge: measured straight up
// far more stays beside the ridge than is there.
TEST(CellBounds, HoldAtARidgeAndComeCloseToWhatStays) {
  const CutterShape cutter = shape(6, 3);
  const double steep = 2, bend = 0.03;  // of the sides; the ridge at x = bend * y
  const auto height = [&](double x, double y) { return -steep * std::fabs(x - bend * y); };
  TriangleMesh mesh;
  mesh.positions = {{-5 * bend, -5, 0},     {5 * bend, 5, 0},       {-9, -5, height(-9, -5)},
                    {-9, 5, height(-9, 5)}, {9, -5, height(9, -5)}, {9, 5, height(9, 5)}};
  mesh.triangles = {{2, 0, 3}, {0, 1, 3}, {0, 4, 1}, {4, 5, 1}};
  std::vector<SweepMove> moves;
  const double lean = std::sqrt(1 + steep * steep * (1 + bend * bend));
  for (int k = 0; k < 12; ++k) {
    for (const double side : {-1.0, 1.0}) {
      const Vec3 normal(side * steep / lean, -side * steep * bend / lean, 1 / lean);
      const auto tip = [&](double y) {
        const double x = bend * y + side * (0.02 + 0.1 * k);
        return Vec3(Vec3(x, y, height(x, y)) + 3 * normal - Vec3(0, 0, 3));
      };
      moves.push_back({tip(-4), tip(4)});
    }
  }
  const PlanLattice lattice{-0.5, -0.5, 0.1, 0.1, 11, 11};
  std::vector<double> part;
  std::vector<std::size_t> cells;
  for (std::size_t k = 0; k < lattice.columns * lattice.rows; ++k) {
    const std::size_t i = k % lattice.columns, j = k / lattice.columns;
    part.push_back(height(lattice.x(i), lattice.y(j)));
    if (i + 1 < lattice.columns && j + 1 < lattice.rows) cells.push_back(k);
  }
  CellBounds look(cutter, lattice, cells, 1);
  look.add(moves, 1);
  const std::vector<double> bounds =
      look.bounds(mesh, 0, std::vector<double>(cells.size(), 1e-4), 1);
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const double x0 = lattice.x(cells[c] % lattice.columns);
    const double y0 = lattice.y(cells[c] / lattice.columns);
    double most = 0;
    for (int a = 0; a <= 20; ++a) {
      for (int b = 0; b <= 20; ++b) {
        const double x = x0 + 0.005 * a, y = y0 + 0.005 * b;
        double left = 1e9;
        for (const SweepMove& m : moves) left = std::fmin(left, swept_height(cutter, m, x, y));
        // The part is what is below both sides; its nearest place is on one or on the ridge.
        const double off = std::fabs(x - bend * y) / std::sqrt(1 + bend * bend);
        const double up = left - height(x, y),
                     foot = up * std::sqrt(lean * lean - 1) / (lean * lean);
        most = std::fmax(most, foot <= off ? up / lean : std::hypot(off, left));
      }
    }
    EXPECT_GE(bounds[c], most - 1e-9) << x0 << " " << y0;
    EXPECT_LE(bounds[c], most + 0.015) << x0 << " " << y0;
  }
}

TEST(VerifyPath, APlannedPathPassesAndSeededErrorsAreFound) {
  const Part p = part();
  const Result<PlannedPath> planned = plan_drop_path(p.mesh, 0, {0, 30, 0, 20}, path_options());
  ASSERT_TRUE(planned) << planned.error().message;
  const auto verify = [&](const ToolPath& path, const VerifyOptions& options) {
    return verify_path(p.surface, p.mesh, 0, path, options).value();
  };
  const VerifyReport good = verify(planned->path, verify_options());
  EXPECT_LE(good.max_gouge, 0.02 + 1e-9);
  EXPECT_GT(good.max_gouge, 0.002);
  EXPECT_LE(good.bound, 0.04 / 256 + 1e-6);  // moves joined
  EXPECT_LE(good.cusp_p99, 0.04);
  EXPECT_GT(good.cusp_p50, 0);
  EXPECT_LT(good.uncut_area, 0.01 * 600);
  EXPECT_EQ(good.rapid_plunges, 0u);
  EXPECT_EQ(good.points, planned->path.points.size());

  // One point lowered by twice the tolerance.
  ToolPath lowered = planned->path;
  const std::size_t victim = lowered.points.size() / 2;
  lowered.points[victim].tip.z() -= 0.04;
  const VerifyReport gouged = verify(lowered, verify_options());
  EXPECT_GT(gouged.max_gouge, 0.03);
  EXPECT_LE((gouged.max_gouge_at - lowered.points[victim].tip).head<2>().norm(), 3.5);

  // A pass left out: leave off two neighbouring rows of points.
  ToolPath missing = planned->path;
  const double row = lowered.points[victim].tip.y();
  std::erase_if(missing.points, [&](const ClPoint& q) {
    return std::fabs(q.tip.y() - row) < 0.3 && q.motion == Motion::kFeed;
  });
  const VerifyReport gap = verify(missing, verify_options());
  EXPECT_GT(gap.max_excess, 1.5 * good.cusp_max);
  EXPECT_GT(gap.uncut_area, good.uncut_area + 1);

  // A wrong cutter: larger ones gouge.
  VerifyOptions larger = verify_options();
  larger.cutter = {8, 4};
  EXPECT_GT(verify(planned->path, larger).max_gouge, 0.1);
  VerifyOptions flat = verify_options();
  flat.cutter = {6, 0};
  EXPECT_GT(verify(planned->path, flat).max_gouge, 0.1);

  // A rapid move down.
  ToolPath plunging = planned->path;
  plunging.points[1].motion = Motion::kRapid;
  EXPECT_EQ(verify(plunging, verify_options()).rapid_plunges, 1u);
}

// On level ground, where what a pass leaves is known: any pass left out is found if that is more
// than the limit, and no fault is found if it is not.
TEST(VerifyPath, AnyMissingPassIsFoundWhereItLeavesMoreThanTheLimit) {
  const double limit = 0.04;
  for (const auto& d : kCutters) {
    const CutterShape cutter = shape(d[0], d[1]);
    for (const double part_of_limit : {0.8, 1.2}) {
      const double ridge = cutter.corner() > 0 ? part_of_limit * limit : 0, r = cutter.corner();
      // A flat end leaves nothing, or all of it.
      const double reach = r > 0 ? cutter.flat() + std::sqrt(ridge * (2 * r - ridge))
                                 : cutter.flat() * (part_of_limit > 1 ? 1.1 : 0.9);
      const int gaps = 5;
      Diagnostics diagnostics;
      const auto program =
          parse_part_program("BSURF-DEF\nPLANE,0\nBOOLE-DEF\nB\nMACHI-DEF\nX-RNG,0,20\nY-RNG,0," +
                                 std::to_string(gaps * reach) + "\n",
                             "plane.part", diagnostics);
      ASSERT_TRUE(program);
      Result<CompoundSurface> made = CompoundSurface::make(*program);
      const CompoundSurface surface = std::move(made.value());
      const double depth = program->machining.y_range[1];
      const TriangleMesh mesh =
          height_mesh(-4, 24, 3, -4, depth + 4, 3, [](double, double) { return 0.0; });
      PathOptions options = path_options();
      options.cutter = {d[0], d[1]};
      options.cusp.reset();
      options.interval = depth / gaps * (1 + 1e-9);
      options.pattern = PathPattern::kOneway;
      const PlannedPath planned = plan_drop_path(mesh, 0, {0, 20, 0, depth}, options).value();
      VerifyOptions check = verify_options();
      check.cutter = options.cutter;
      check.spacing = depth / gaps / 8;
      EXPECT_EQ(verify_path(surface, mesh, 0, planned.path, check).value().uncut_area, 0);
      for (int pass = 0; pass <= gaps; ++pass) {
        ToolPath missing = planned.path;
        const std::size_t count = std::erase_if(missing.points, [&](const ClPoint& q) {
          return std::fabs(q.tip.y() - depth / gaps * pass) < 1e-6;
        });
        ASSERT_GE(count, 2u);
        const VerifyReport found = verify_path(surface, mesh, 0, missing, check).value();
        if (part_of_limit > 1) {
          EXPECT_GT(found.uncut_area, 0) << d[1] << " pass " << pass;
        } else {
          EXPECT_EQ(found.uncut_area, 0) << d[1] << " pass " << pass;
        }
        if (r > 0) {
          EXPECT_NEAR(found.max_excess, ridge, 1e-5) << d[1] << " pass " << pass;
        }
      }
    }
  }
}

TEST(VerifyPath, SameForAnyThreads) {
  const Part p = part();
  const Result<PlannedPath> planned = plan_drop_path(p.mesh, 0, {0, 30, 0, 20}, path_options());
  ASSERT_TRUE(planned);
  VerifyOptions options = verify_options();
  options.threads = 1;
  const VerifyReport one = verify_path(p.surface, p.mesh, 0, planned->path, options).value();
  options.threads = 7;
  const VerifyReport seven = verify_path(p.surface, p.mesh, 0, planned->path, options).value();
  EXPECT_EQ(one.max_gouge, seven.max_gouge);
  EXPECT_EQ(one.max_gouge_at, seven.max_gouge_at);
  EXPECT_EQ(one.height, seven.height);
  EXPECT_EQ(one.state, seven.state);
  EXPECT_EQ(one.cusp_p50, seven.cusp_p50);
}

TEST(VerifyPath, ABlindPathIsNotCalledGood) {
  const Part p = part();
  // Three passes over a part of the domain only, well above.
  ToolPath path;
  path.points = {
      {{0, 0, 20}, Motion::kRapid}, {{0, 0, 5}, Motion::kFeed}, {{30, 0, 5}, Motion::kFeed}};
  const VerifyReport report = verify_path(p.surface, p.mesh, 0, path, verify_options()).value();
  EXPECT_EQ(report.max_gouge, 0);
  EXPECT_GT(report.max_excess, 4.9);
  EXPECT_GT(report.uncut_area, 500);
}

CompoundSurface surface_of(const std::string& solids, const std::string& boole,
                           const std::string& domain) {
  Diagnostics diagnostics;
  const auto program = parse_part_program(
      "SOLID-DEF\n" + solids + "BSURF-DEF\nPLANE,0\nBOOLE-DEF\n" + boole + "\nMACHI-DEF\n" + domain,
      "part", diagnostics);
  Result<CompoundSurface> made = CompoundSurface::make(*program);
  return std::move(made.value());
}

struct Checked {
  VerifyReport found;
  double deviation = 0;
};

Checked checked(const CompoundSurface& surface, const ToolPath& path, const Cutter& cutter,
                double outtol, double cusp) {
  TessellationOptions how;
  how.tolerance = outtol / 16;
  const Tessellation mesh = tessellate(widened(surface, cutter.diameter / 2).value(), how).value();
  VerifyOptions options;
  options.cutter = cutter;
  options.intol = options.outtol = outtol;
  options.cusp = cusp;
  options.threads = 2;
  const double deviation = mesh.report.certified_deviation;
  return {verify_path(surface, mesh.mesh, deviation, path, options).value(), deviation};
}

VerifyReport of_planned(const CompoundSurface& surface, const Cutter& cutter) {
  PathOptions options;
  options.cutter = cutter;
  options.cusp = 0.1;
  options.intol = options.outtol = 0.01;
  options.threads = 2;
  return checked(surface, plan_path(surface, options).value().path, cutter, 0.01, 0.1).found;
}

constexpr char kBlock[] = "S1,4-PRIS,3\nP1,10,-5,-1\nP2,20,30,4\n";

// A wall that was followed too far off: as much stays on it as was left, and not the next number
// that a search by doublings comes to.
TEST(VerifyPath, OnAWallItTellsHowMuchIsLeft) {
  const CompoundSurface surface = surface_of(kBlock, "B+S1", "X-RNG,0,30\nY-RNG,0,20\nTOLER,.01\n");
  for (const double off : {0.033, 0.05, 0.071}) {
    ToolPath path;
    // The ground, then the top; a flat end of 6 all over both.
    path.points = {{{0, 0, 20}, Motion::kRapid}};
    const auto pass = [&](double x, double z) {
      const bool up = path.points.size() % 4 < 2;
      path.points.push_back({{x, up ? 0.0 : 20.0, path.points.back().tip.z()}, Motion::kFeed});
      path.points.push_back({{x, up ? 0.0 : 20.0, z}, Motion::kFeed});
      path.points.push_back({{x, up ? 20.0 : 0.0, z}, Motion::kFeed});
      path.points.push_back({{x, up ? 20.0 : 0.0, 20}, Motion::kFeed});
    };
    for (const double x : {0.0, 3.5, 7 - off}) pass(x, 0);
    for (const double x : {9.0, 12.0, 15.0, 18.0, 21.0}) pass(x, 4);
    for (const double x : {23.0, 26.5, 30.0}) pass(x, 0);
    const Checked result = checked(surface, path, {6, 0}, 0.01, 0.01);
    const double touch = 2 * result.deviation + 0.02 / 16;
    EXPECT_EQ(result.found.max_gouge, 0);
    EXPECT_LE(result.found.max_excess, off + 1e-9) << off;
    // Cells of 0.075 are divided to sixteenths.
    EXPECT_LE(result.found.max_excess + result.found.excess_bound, off + 0.006) << off;
    EXPECT_GE(result.found.max_excess + result.found.excess_bound, off - touch) << off;
  }
}

// Between the points of a path that keeps the limit no more is told to stay than does: beside a
// wall that runs along a row of the lattice, on sides that steepen to upright, where a flat end's
// passes end beside each other. What a planner leaves between its own points is a little more.
// Of a limit of 0 no multiple is more: how deep a cutter beside a wall may hold what stands there
// is looked for from what a touch is.
TEST(VerifyPath, WithoutAnyToleranceItEnds) {
  const CompoundSurface surface = test::fixture("fig6");
  PathOptions options;
  options.cutter = {6, 3};
  options.interval = 1;
  options.intol = options.outtol = 0.02;
  options.threads = 2;
  const PlannedPath planned = plan_path(surface, options).value();
  TessellationOptions fine;
  fine.tolerance = 0.005;
  const Tessellation mesh = tessellate(surface, fine).value();
  VerifyOptions check;
  check.cutter = {4, 2};
  check.spacing = 0.4;
  check.threads = 2;
  const VerifyReport found =
      verify_path(surface, mesh.mesh, mesh.report.certified_deviation, planned.path, check).value();
  EXPECT_EQ(found.limit, 0);
  EXPECT_GT(found.uncut_area, 300);
  EXPECT_GT(found.max_excess, 0.5);
}

TEST(VerifyPath, TheBoundBetweenThePointsIsNearTheLimit) {
  const CompoundSurface wall = surface_of(kBlock, "B+S1", "X-RNG,0,30\nY-RNG,0,20\nTOLER,.01\n");
  const CompoundSurface log = surface_of("S1,R-CYLI,1\nP1,-5,8,0\nP2,30,14,0\nRAD,3\n", "B+S1",
                                         "X-RNG,0,24\nY-RNG,0,20\nTOLER,.01\n");
  for (const auto& [name, surface] : {std::pair{"wall", &wall}, {"log", &log}}) {
    for (const Cutter& cutter : {Cutter{6, 3}, Cutter{6, 0}}) {
      const VerifyReport found = of_planned(*surface, cutter);
      EXPECT_LE(found.max_excess + found.excess_bound, 0.16)
          << name << " " << cutter.corner_radius << " excess " << found.max_excess;
      EXPECT_GE(found.proven_part, 0.995) << name << " " << cutter.corner_radius;
    }
  }
}

}  // namespace
}  // namespace diesink
