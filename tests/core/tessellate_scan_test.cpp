// Meshes over a scanned base: closed, sharp against the solids, within the tolerance of the scan.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <numbers>

#include "core/base/scan_sheet.h"
#include "core/base/scan_thin.h"
#include "core/compound/compound_impl.h"
#include "core/tessellate/scan_arcs.h"
#include "core/tessellate/scan_mesh.h"
#include "tests/support/height_mesh.h"
#include "tests/support/load_part.h"
#include "tests/support/mesh_proof.h"

namespace diesink::test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

CompoundSurface over(TriangleMesh scan, const std::string& solids, const std::string& expression,
                     const std::string& machining = "TOLER,.02\n") {
  const PartProgram program =
      program_of((solids.empty() ? "" : "SOLID-DEF\n" + solids) + "BSURF-DEF\nMESH,scan.stl\n" +
                 "BOOLE-DEF\n" + expression + "\nMACHI-DEF\n" + machining);
  Result<CompoundSurface> surface = CompoundSurface::make(program, std::move(scan));
  if (!surface) throw std::runtime_error(to_text(surface.error()));
  return std::move(*surface);
}

// The same noise everywhere: -1 .. 1.
double noise(double x, double y) {
  const double s = std::sin(12.9898 * x + 78.233 * y) * 43758.5453;
  return 2 * (s - std::floor(s)) - 1;
}

double relief(double x, double y) { return 2 * std::sin(x / 9) * std::cos(y / 7); }

TriangleMesh noisy(std::uint32_t n, double amplitude) {
  return height_mesh(0, 60, n, 0, 40, n * 2 / 3,
                     [&](double x, double y) { return relief(x, y) + amplitude * noise(x, y); });
}

// Of the tolerance: how far beside an upright wall of the scan, or the wall under a rim, a point of
// what stands for it may lie. A wall becomes a strip 0.1 of the tolerance wide;
// ScanSheet::moved allows twice that.
constexpr double kWallLean = 0.2;

// How far beside the scan points of curves may be: where nothing stands upright they are on it.
double beside_scan(const CompoundSurface& surface, const TessellationReport& report) {
  const auto& scan = std::get<ScannedSurface>(surface.impl().base);
  const bool walls = scan.upright() > 0 || scan.layers(1).any();
  return (walls ? kWallLean * (1 + 1e-6) * report.tolerance : 0) + report.crease_offset;
}

constexpr const char* kBoss = "S1,R-CYLI,2\nP1,20,20,-5\nNOR,.1,.2,1\nRAD,7\nLEN,14\n";
constexpr const char* kPocket = "S2,SPHER\nP1,42,22,3\nRAD,9\n";

// The faces cover the plan once, but for what chords beside a steep silhouette may cut.
void check_plan(const Tessellation& made, Faults& faults) {
  const TriangleMesh& mesh = made.mesh;
  double over = 0, sum = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (role_of(mesh, t) != ElementRole::kFace) continue;
    const auto& v = mesh.triangles[t];
    const double twice =
        plan_area2(mesh.positions[v[0]], mesh.positions[v[1]], mesh.positions[v[2]]);
    sum += 0.5 * twice;
    over += std::fmax(-0.5 * twice, 0.0);
  }
  const auto& d = made.report.domain;
  const double domain = (d[1] - d[0]) * (d[3] - d[2]);
  // (A face that stands upright at its silhouette: what its chords may be off, along 4e-3 of the
  // domain's side.)
  if (over > 4e-3 * std::sqrt(domain) * made.report.tolerance + 1e-6 * domain)
    faults.add("plan area of what is turned over", over, 0.0);
  if (sum > domain * (1 + 1e-9)) faults.add("plan area beyond the domain", sum, domain);
}

// The mesh of a surface, in `faults` what is wrong with it by topology, plan and distance.
Result<Tessellation> looked_at(const CompoundSurface& surface, bool solid, Faults& faults) {
  TessellationOptions options;
  options.solid = solid;
  Result<Tessellation> made = tessellate(surface, options);
  if (!made) return made;
  check_topology(made->mesh, solid, faults);
  check_plan(*made, faults);
  check_deviation(surface, *made, made->report.tolerance, 1500, 1, faults);
  return made;
}

// Faults of the sheet and of the solid; `told` is the part of the plan that may be told as not
// certified; vertices where a solid meets the base lie on the solid and on a facet of the
// scan, or as far beside it as what stands for an upright wall leans.
std::string faults_over(const CompoundSurface& surface, bool solid,
                        std::size_t* triangles = nullptr, double told = 1e-9) {
  Faults faults;
  const Result<Tessellation> made = looked_at(surface, solid, faults);
  if (!made) return "refused: " + to_text(made.error());
  if (triangles != nullptr) *triangles = made->mesh.triangles.size();
  check_report(*made, solid, faults);
  check_curves(surface, *made, faults, 0, beside_scan(surface, made->report));
  // (Needles whose bound cannot be shown have no area to speak of.)
  const auto& d = made->report.domain;
  if (made->report.uncertified_area > told * (d[1] - d[0]) * (d[3] - d[2]))
    faults.add("uncertified area", made->report.uncertified_area, 0.0);
  return faults.text();
}

TEST(TessellateScan, BossAndPocketOnANoisyScan) {
  const CompoundSurface surface = over(noisy(61, 0.01), std::string(kBoss) + kPocket, "B+S1-S2");
  EXPECT_EQ(faults_over(surface, false), "");
  EXPECT_EQ(faults_over(surface, true), "");
}

TEST(TessellateScan, NothingButTheScan) {
  EXPECT_EQ(faults_over(over(noisy(41, 0.05), "", "B"), true), "");
}

TEST(TessellateScan, FlatScanTakesFewTriangles) {
  std::size_t triangles = 0;
  const CompoundSurface surface =
      over(height_mesh(0, 60, 301, 0, 40, 201,
                       [](double x, double y) { return 0.1 * x + 0.05 * y + 0.004 * noise(x, y); }),
           "", "B");
  EXPECT_EQ(faults_over(surface, false, &triangles), "");
  EXPECT_LT(triangles, 200u);
}

TEST(TessellateScan, HolesEndTheSurface) {
  TriangleMesh scan = height_mesh(0, 60, 61, 0, 40, 41, [](double x, double y) {
    return std::hypot(x - 44, y - 24) < 6 || std::hypot(x - 20, y - 27) < 4 ? kNaN : relief(x, y);
  });
  for (Vec3& p : scan.positions) {
    if (std::isnan(p.z())) p.z() = 0;  // no triangle has it
  }
  const CompoundSurface surface =
      over(scan, "S1,R-CYLI,2\nP1,20,20,-5\nNOR,.1,.1,1\nRAD,7\nLEN,13\n" + std::string(kPocket),
           "B+S1-S2");
  EXPECT_EQ(faults_over(surface, false), "");
  EXPECT_EQ(faults_over(surface, true), "");
}

// A plateau pushed outwards over the ground: layers over one another under its rim.
TriangleMesh overhanging() {
  TriangleMesh scan = height_mesh(0, 60, 61, 0, 40, 41, [](double x, double y) {
    return 6 / (1 + std::exp((std::hypot(x - 38, y - 21) - 9) / 0.7));
  });
  for (Vec3& p : scan.positions) {
    const Vec2 out(p.x() - 38, p.y() - 21);
    const double r = out.norm();
    if (r > 0) p.head<2>() += 3 * std::exp(-(r - 8) * (r - 8) / 1.5) / r * out;
  }
  return scan;
}

TEST(TessellateScan, OverhangIsSeenFromAbove) {
  const CompoundSurface surface = over(overhanging(), kBoss, "B+S1", "TOLER,.05\n");
  EXPECT_EQ(faults_over(surface, true), "");
}

// A plate with a block on it, closed, all walls upright: facets without a plan of their own.
TriangleMesh block_on_plate() {
  TriangleMesh scan;
  const auto box = [&](double x0, double x1, double y0, double y1, double z0, double z1) {
    const auto v = static_cast<std::uint32_t>(scan.positions.size());
    for (const double z : {z0, z1}) {
      for (const auto& [x, y] : {std::pair{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}})
        scan.positions.emplace_back(x, y, z);
    }
    for (const auto& t : {std::array<std::uint32_t, 3>{0, 2, 1},
                          {0, 3, 2},
                          {4, 5, 6},
                          {4, 6, 7},
                          {0, 1, 5},
                          {0, 5, 4},
                          {1, 2, 6},
                          {1, 6, 5},
                          {2, 3, 7},
                          {2, 7, 6},
                          {3, 0, 4},
                          {3, 4, 7}})
      scan.triangles.push_back({v + t[0], v + t[1], v + t[2]});
  };
  box(0, 60, 0, 40, -5, 0);
  box(20, 40, 10, 30, 0, 8);
  return scan;
}

TEST(TessellateScan, UprightWallsOfTheScanAreWalls) {
  // (The pocket cuts through the block's wall, the boss stands on the plate.)
  const std::string solids =
      "S1,R-CYLI,2\nP1,10,20,-3\nNOR,.1,.2,1\nRAD,5\nLEN,8\nS2,SPHER\nP1,41,20,8\nRAD,5\n";
  for (const std::string expression : {"B", "B+S1", "B+S1-S2"}) {
    const CompoundSurface surface = over(block_on_plate(), solids, expression);
    EXPECT_EQ(faults_over(surface, true), "") << expression;
  }
}

// A closed cube of 20, each side n x n squares, every vertex off by up to `rough`: walls that lean
// in and out, with folds and overhangs.
TriangleMesh rough_cube(std::uint32_t n, double rough, double seed) {
  TriangleMesh cube;
  std::map<std::array<std::uint32_t, 3>, std::uint32_t> vertex;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const std::uint32_t side : {0u, n}) {
      for (std::uint32_t i = 0; i < n; ++i) {
        for (std::uint32_t j = 0; j < n; ++j) {
          std::array<std::uint32_t, 4> corner{};
          for (std::uint32_t k = 0; k < 4; ++k) {
            std::array<std::uint32_t, 3> at{};
            at[axis] = side;
            at[(axis + 1) % 3] = i + (k == 1 || k == 2 ? 1 : 0);
            at[(axis + 2) % 3] = j + (k >= 2 ? 1 : 0);
            const auto [it, fresh] =
                vertex.try_emplace(at, static_cast<std::uint32_t>(cube.positions.size()));
            if (fresh) {
              const Vec3 p = 20.0 / n * Vec3(at[0], at[1], at[2]) - Vec3(10, 10, 10);
              cube.positions.push_back(p + rough * Vec3(noise(p.x() + 3 * p.z() + seed, p.y()),
                                                        noise(p.y() + seed, p.z() - p.x()),
                                                        noise(p.z() + seed, p.x() + 2 * p.y())));
            }
            corner[k] = it->second;
          }
          if (side == 0) std::swap(corner[1], corner[3]);
          cube.triangles.push_back({corner[0], corner[1], corner[2]});
          cube.triangles.push_back({corner[0], corner[2], corner[3]});
        }
      }
    }
  }
  return cube;
}

// Borders that cross, at the rim of the scan too, cost nothing but triangles: no die falls back to
// the plain grid for them, chords laid straight still follow the facets, and where edges of the
// scan have given way to chords it is measured how far off that is.
TEST(TessellateScan, BordersThatCrossAreLaidStraight) {
  const std::string solids =
      "S1,R-CYLI,2\nP1,-3,-2,-10\nNOR,.1,.2,1\nRAD,3\nLEN,24\nS2,SPHER\nP1,3,2,10\nRAD,4\n";
  struct Cube {
    std::uint32_t n;
    double rough, seed;
  };
  for (const auto& [n, rough, seed] : {Cube{10, 0.3, 4}, Cube{16, 0.1, 1}, Cube{16, 0.3, 3}}) {
    const CompoundSurface surface =
        over(rough_cube(n, rough, seed), solids, "B+S1-S2", "TOLER,.04\nX-INT,.5\nY-INT,.5\n");
    for (const bool solid : {false, true}) {
      Faults faults;
      const Result<Tessellation> made = looked_at(surface, solid, faults);
      ASSERT_TRUE(made) << to_text(made.error());
      EXPECT_EQ(faults.text(), "") << rough;
      EXPECT_GT(made->report.certified_deviation, 0)
          << rough;  // not the grid, which proves nothing
      EXPECT_EQ(made->report.uncertified_area, 0) << rough;
    }
  }
}

// Chords whose nodes have moved too far to be known as the sheet's own vertices: those that lie
// under them are left out and what is no piece of the scan any more is told. The die was refused.
TEST(TessellateScan, VerticesUnderChordsAreLeftOut) {
  const CompoundSurface scan = over(noisy(12, 0.3), kBoss, "B+S1");
  const PlanBox box{0, 60, 0, 40};
  const ScanSheet sheet = top_sheet(std::get<ScannedSurface>(scan.impl().base), box, 0.002, 1);
  TriangleMesh mesh;
  mesh.positions = sheet.points;
  mesh.triangles = sheet.triangles;
  const CompoundSurface surface = over(std::move(mesh), kBoss, "B+S1");
  ArrangementOptions options;
  options.tolerance = 0.02;
  options.threads = 1;
  Result<Arrangement> arrangement = arrange(surface, box, options);
  ASSERT_TRUE(arrangement) << to_text(arrangement.error());
  ScanArcs arcs = cut_arcs(surface.impl(), sheet, 1e-6, *arrangement);
  for (ScanPlace& place : arcs.place) place = {};
  std::fill(arcs.node_at.begin(), arcs.node_at.end(), ScanSheet::kNone);
  SamplingOptions sampling;
  sampling.sag = sampling.flat_sag = sampling.tolerance = 0.01;
  sampling.shortest = 0.01;
  ArcSamples samples(surface.impl(), *arrangement, sampling);
  samples.sample_all(1);
  const Result<ScanCut> cut = cut_sheet(surface.impl(), *arrangement, samples, sheet, arcs, 1e-9);
  ASSERT_TRUE(cut) << to_text(cut.error());
  double seen = 0, within = 0;
  for (std::size_t t = 0; t < cut->sheet.triangles.size(); ++t) {
    const auto& v = cut->sheet.triangles[t];
    const double twice =
        plan_area2(cut->sheet.points[v[0]], cut->sheet.points[v[1]], cut->sheet.points[v[2]]);
    EXPECT_GT(twice, 0);
    if (cut->base[t]) seen += 0.5 * twice;
  }
  std::vector<std::uint32_t> chain;
  for (const ArcUse& use : cut->uses) {
    samples.chain(use.arc, chain);
    for (std::size_t k = 0; k + 1 < chain.size(); ++k) {
      const ArcPoint &p = samples.points[chain[k]], &q = samples.points[chain[k + 1]];
      within += 0.5 * (p.x * q.y - p.y * q.x) * (use.forward ? 1 : -1);
    }
  }
  EXPECT_NEAR(seen, within, 1e-9 * within);
  EXPECT_GT(cut->unproven_area, 0);
  EXPECT_LT(cut->unproven_area, 0.5 * within);  // beside the arcs and the border alone
}

// As of a block turned in space: its walls lean by rounding, this way and that, and its floor is
// none.
TEST(TessellateScan, WallsThatLeanByRoundingAreUpright) {
  TriangleMesh scan = block_on_plate();
  Random random(3);
  for (Vec3& p : scan.positions) {
    for (int axis = 0; axis < 3; ++axis) p[axis] += random.uniform(-4e-15, 4e-15);
  }
  const std::string solids =
      "S1,R-CYLI,2\nP1,10,20,-3\nNOR,.1,.2,1\nRAD,5\nLEN,8\nS2,SPHER\nP1,41,20,8\nRAD,5\n";
  for (const std::string expression : {"B", "B+S1-S2"}) {
    EXPECT_EQ(faults_over(over(scan, solids, expression), true), "") << expression;
  }
}

// Two quarters of a relief, one lifted, that meet in a point: the whole scan was refused for it.
TEST(TessellateScan, FacetsMayMeetInOnePointAtTwoHeights) {
  TriangleMesh scan;
  for (const auto& [x0, y0, lift] : {std::array{0.0, 0.0, 0.0}, std::array{30.0, 20.0, 3.0}}) {
    const TriangleMesh quarter = height_mesh(
        x0, x0 + 30, 11, y0, y0 + 20, 9, [&](double x, double y) { return relief(x, y) + lift; });
    const auto first = static_cast<std::uint32_t>(scan.positions.size());
    for (const Vec3& p : quarter.positions) scan.positions.push_back(p);
    for (const auto& t : quarter.triangles)
      scan.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  const CompoundSurface surface = over(scan, kBoss, "B+S1");
  for (const bool solid : {false, true}) {
    Faults faults;
    const Result<Tessellation> made = looked_at(surface, solid, faults);
    ASSERT_TRUE(made) << to_text(made.error());
    EXPECT_EQ(faults.text(), "") << solid;
    EXPECT_EQ(made->report.uncertified_area, 0) << solid;
  }
}

// Facets that do not share their vertices to the bit, as files of rounded numbers hold them, leave
// gaps, layers and slivers along the domain's sides.
TEST(TessellateScan, CracksOfRoundingAreClosed) {
  const TriangleMesh whole = noisy(41, 0.02);
  TriangleMesh scan;
  Random random(7);
  for (const auto& t : whole.triangles) {
    const auto first = static_cast<std::uint32_t>(scan.positions.size());
    for (const std::uint32_t v : t) {
      Vec3 p = whole.positions[v];
      for (int axis = 0; axis < 3; ++axis) p[axis] += random.uniform(-2e-6, 2e-6);
      scan.positions.push_back(p);
    }
    scan.triangles.push_back({first, first + 1, first + 2});
  }
  const std::string solids = std::string(kBoss) + kPocket;
  std::size_t triangles = 0, of_whole = 0;
  EXPECT_EQ(faults_over(over(scan, solids, "B+S1-S2"), true, &triangles), "");
  EXPECT_EQ(faults_over(over(whole, solids, "B+S1-S2"), true, &of_whole), "");
  EXPECT_LT(triangles, of_whole + of_whole / 10);
}

TEST(TessellateScan, WallsAlongTheEdgesOfTheScan) {
  // The box's walls stand exactly on the scan's own lines, its corners on vertices.
  const std::string box = "S1,4-PRIS,3\nP1,10,10,-5\nP2,30,25,4\n";
  const CompoundSurface surface = over(noisy(61, 0.01), box, "B+S1");
  EXPECT_EQ(faults_over(surface, true), "");
}

TEST(TessellateScan, FlatTopGrazesTheScan) {
  const std::string box = "S1,4-PRIS,3\nP1,10.3,10.3,-5\nP2,50.3,30.3,1.2\n";
  EXPECT_EQ(faults_over(over(noisy(61, 0.01), box, "B+S1"), true), "");
}

TEST(TessellateScan, GroupsAndDomainInsideTheScan) {
  const CompoundSurface surface =
      over(noisy(61, 0.01), std::string(kBoss) + kPocket, "B+(S1-S2)-S2",
           "TOLER,.02\nX-RNG,7.3,51.1\nY-RNG,5.2,33.9\n");
  EXPECT_EQ(faults_over(surface, true), "");
}

TEST(TessellateScan, FeatureEdgesAreCreases) {
  // A roof: one sharp ridge that no thinning may lose.
  const CompoundSurface surface =
      over(height_mesh(0, 60, 61, 0, 40, 41, [](double, double y) { return -std::fabs(y - 20); }),
           kBoss, "B+S1");
  EXPECT_EQ(faults_over(surface, true), "");
  const Result<Tessellation> made = tessellate(surface, {});
  ASSERT_TRUE(made);
  double ridge = 0;
  for (const CurveReport& c : made->report.curves) {
    if (c.between[0] == "B" && c.between[1] == "B") ridge += c.length;
  }
  EXPECT_NEAR(ridge, 60 - 14, 1.5);  // but for what the boss covers
}

// A roof whose two sides turn by `degrees` at the ridge.
double ridge_drawn(double degrees) {
  const double slope = std::tan(degrees / 2 * std::numbers::pi / 180);
  const CompoundSurface surface =
      over(height_mesh(0, 60, 61, 0, 40, 41,
                       [&](double, double y) { return -slope * std::fabs(y - 20); }),
           "", "B");
  const Result<Tessellation> made = tessellate(surface, {});
  double ridge = 0;
  for (const CurveReport& c : made->report.curves) {
    if (c.between[0] == "B" && c.between[1] == "B") ridge += c.length;
  }
  return ridge;
}

TEST(TessellateScan, TheFeatureAngleDecides) {
  EXPECT_EQ(ridge_drawn(29.9), 0);
  EXPECT_NEAR(ridge_drawn(30.1), 60, 1e-9);
}

TEST(TessellateScan, TheGridHasItsEdgePoints) {
  for (const bool overhang : {false, true}) {
    const CompoundSurface surface =
        over(overhang ? overhanging() : noisy(61, 0.01), std::string(kBoss) + kPocket, "B+S1-S2");
    for (const bool solid : {false, true}) {
      TessellationOptions options;
      options.scheme = MeshScheme::kGrid;
      options.solid = solid;
      const Result<Tessellation> made = tessellate(surface, options);
      ASSERT_TRUE(made);
      Faults faults;
      check_topology(made->mesh, solid, faults);
      check_curves(surface, *made, faults, 0, kWallLean * made->report.tolerance);
      EXPECT_EQ(faults.text(), "") << overhang << solid;
      double rim = 0;
      for (const CurveReport& c : made->report.curves) {
        if (c.between[0] == "S1.top" || c.between[1] == "S1.top") rim += c.length;
      }
      EXPECT_GT(rim, 2 * std::numbers::pi * 7 - 0.5);
    }
  }
}

// Facet by facet, sharing nothing with what makes the mesh: vertices and middles of the scan's
// facets that are seen lie within the tolerance of the base's triangles, and theirs of the facets.
TEST(TessellateScan, TheScanAndItsMeshAreNearEachOtherBothWays) {
  const TriangleMesh scan = noisy(61, 0.015);
  const CompoundSurface surface = over(scan, std::string(kBoss) + kPocket, "B+S1-S2");
  const Result<Tessellation> made = tessellate(surface, {});
  ASSERT_TRUE(made);
  const double t = made->report.tolerance;
  const auto near = [&](const TriangleMesh& mesh, const Vec3& p) {
    double least = HUGE_VAL;
    for (std::size_t k = 0; k < mesh.triangles.size(); ++k) {
      const auto& v = mesh.triangles[k];
      const Vec3 &a = mesh.positions[v[0]], &b = mesh.positions[v[1]], &c = mesh.positions[v[2]];
      const auto beyond = [&](int axis) {
        return std::fmax(std::min({a[axis], b[axis], c[axis]}) - p[axis],
                         p[axis] - std::max({a[axis], b[axis], c[axis]})) > t;
      };
      if (!beyond(0) && !beyond(1)) least = std::fmin(least, MeshInPlan::to_triangle(p, a, b, c));
    }
    return least <= t * (1 + 1e-9);
  };
  std::size_t compared = 0;
  for (std::size_t k = 0; k < scan.triangles.size(); k += 7) {
    const auto& v = scan.triangles[k];
    const Vec3 m = (scan.positions[v[0]] + scan.positions[v[1]] + scan.positions[v[2]]) / 3;
    for (const Vec3& p : {m, scan.positions[v[0]]}) {
      const std::optional<CcDatum> hit = surface.at(p.x(), p.y());
      if (!hit || surface.surface_of_row(hit->row) != 0) continue;
      EXPECT_TRUE(near(made->mesh, p)) << p.transpose();
      ++compared;
    }
  }
  for (std::size_t k = 0; k < made->mesh.triangles.size(); ++k) {
    if (made->mesh.elements[made->mesh.triangle_element[k]].name != "B") continue;
    const auto& v = made->mesh.triangles[k];
    Vec3 m = Vec3::Zero();
    for (const std::uint32_t i : v) m += made->mesh.positions[i] / 3;
    EXPECT_TRUE(near(scan, m)) << m.transpose();
    ++compared;
  }
  EXPECT_GT(compared, 1000u);
}

TEST(TessellateScan, ThinnedSheetKeepsItsWord) {
  const CompoundSurface surface = over(noisy(91, 0.02), "", "B");
  const ScannedSurface& scan = std::get<ScannedSurface>(surface.impl().base);
  ScanSheet sheet = top_sheet(scan, scan.plan_box(), 1e-3);
  const std::size_t before = sheet.triangles.size();
  ThinOptions how;
  how.tolerance = 0.03;
  how.feature_angle = 0.5;
  how.box = scan.plan_box();
  const double told = thin_sheet(sheet, how);
  EXPECT_LT(sheet.triangles.size(), before / 3);
  EXPECT_LE(told, 0.03);
  TriangleMesh mesh;
  mesh.positions = sheet.points;
  mesh.triangles = sheet.triangles;
  const Result<ScannedSurface> thin = ScannedSurface::make(mesh, {});
  ASSERT_TRUE(thin);
  double worst = 0;
  Random random(5);
  for (int k = 0; k < 200000; ++k) {
    const double x = random.uniform(0, 60), y = random.uniform(0, 40);
    BaseHit a, b;
    ASSERT_TRUE(scan.at(x, y, a) && thin->at(x, y, b));
    worst = std::fmax(worst, std::fabs(a.z - b.z));
  }
  EXPECT_LE(worst, told * (1 + 1e-9));
  EXPECT_GE(worst, 0.5 * told);  // the bound is a measurement
}

TEST(TessellateScan, SameBytesForAnyThreads) {
  const CompoundSurface surface = over(noisy(61, 0.01), std::string(kBoss) + kPocket, "B+S1-S2");
  TessellationOptions one, three;
  one.threads = 1;
  three.threads = 3;
  const Result<Tessellation> a = tessellate(surface, one), b = tessellate(surface, three);
  ASSERT_TRUE(a && b);
  EXPECT_TRUE(same_bytes(a->mesh, b->mesh));
}

// Scans of several kinds by seed: noisy reliefs, faceted dies, with holes, closed bodies.
TriangleMesh random_scan(Random& random) {
  const int kind = random.below(4);
  const auto n = static_cast<std::uint32_t>(16 + random.below(40));
  const double rough = random.uniform(0, 0.04), wave = random.uniform(5, 15);
  const Vec2 hole{random.uniform(10, 50), random.uniform(10, 30)};
  const double radius = random.uniform(2, 7), slope = random.uniform(0.2, 1.5);
  TriangleMesh scan = height_mesh(0, 60, n, 0, 40, n * 2 / 3, [&](double x, double y) {
    if (kind == 2 && std::hypot(x - hole.x(), y - hole.y()) < radius) return kNaN;
    if (kind == 1) return -slope * std::fmax(std::fabs(y - 20), std::fabs(x - 30) - 10);
    return 2 * std::sin(x / wave) * std::cos(y / wave) + rough * noise(x, y);
  });
  for (Vec3& p : scan.positions) {
    if (std::isnan(p.z())) p.z() = 0;  // no triangle has it
  }
  if (kind == 3) {  // a floor under it: a closed body, as far as a vertical line can tell
    const auto first = static_cast<std::uint32_t>(scan.positions.size());
    for (const auto& [x, y] : {std::pair{0, 0}, {60, 0}, {60, 40}, {0, 40}})
      scan.positions.emplace_back(x, y, -20);
    scan.triangles.push_back({first, first + 2, first + 1});
    scan.triangles.push_back({first, first + 3, first + 2});
  }
  return scan;
}

// A solid somewhere over the plan, text for the number `id`.
std::string random_solid(Random& random, int id) {
  const auto number = [](double v) { return std::to_string(v); };
  const std::string name = "S" + std::to_string(id);
  const double x = random.uniform(8, 52), y = random.uniform(8, 32), r = random.uniform(2, 7);
  const std::string at = number(x) + ',' + number(y) + ',';
  const Vec3 d = random.direction();
  switch (random.below(4)) {
    case 0:
      return name + ",SPHER\nP1," + at + number(random.uniform(-3, 3)) + "\nRAD," + number(r) +
             '\n';
    case 1:
      return name + ",4-PRIS,3\nP1," + at + "-6\nP2," + number(x + r) + ',' + number(y + 2 * r) +
             ',' + number(random.uniform(-1, 5)) + '\n';
    case 2:
      return name + ",R-CYLI,2\nP1," + at + "-6\nNOR," + number(0.3 * d.x()) + ',' +
             number(0.3 * d.y()) + ",1\nRAD," + number(r) + "\nLEN," +
             number(random.uniform(5, 12)) + '\n';
    default:
      return name + ",R-CYLI,2\nP1," + at + number(random.uniform(-1, 2)) + "\nNOR," +
             number(d.x()) + ',' + number(d.y()) + ',' + number(0.2 * d.z()) + "\nRAD," +
             number(r) + "\nLEN," + number(random.uniform(5, 30)) + '\n';
  }
}

// DIESINK_SCAN_SEEDS=from:to makes a soak of it.
TEST(TessellateScan, RandomScansWithRandomSolids) {
  int from = 1, to = 140;
  if (const char* seeds = std::getenv("DIESINK_SCAN_SEEDS"); seeds != nullptr) {
    ASSERT_EQ(std::sscanf(seeds, "%d:%d", &from, &to), 2);
  }
  for (int seed = from; seed < to; ++seed) {
    Random random(static_cast<std::uint64_t>(seed));
    const int solids = 1 + random.below(4);
    std::string text, expression = "B";
    TriangleMesh scan = random_scan(random);
    for (int id = 1; id <= solids; ++id) {
      text += random_solid(random, id);
      expression += (random.chance(0.5) ? "+S" : "-S") + std::to_string(id);
    }
    const CompoundSurface surface = over(std::move(scan), text, expression);
    const std::string faults = faults_over(surface, seed % 2 == 0, nullptr, 1e-6);
    EXPECT_EQ(faults, "") << "seed " << seed << '\n' << text << expression;
  }
}

}  // namespace
}  // namespace diesink::test
