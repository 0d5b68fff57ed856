// Tiles of a domain, each made without the others, against each other to the bit and against the
// domain made as a whole.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "core/tessellate/tessellate.h"
#include "tests/support/height_mesh.h"
#include "tests/support/load_part.h"
#include "tests/support/mesh_proof.h"
#include "tests/support/named_cases.h"
#include "tests/support/random_program.h"
#include "tests/support/tiles.h"

namespace diesink::test {
namespace {

constexpr std::array<int, 2> kTilings[] = {{2, 2}, {3, 2}, {4, 1}, {1, 5}};

// What a certified whole keeps its tiles keep; the seams agree; welded they are the whole.
std::string tile_faults(const CompoundSurface& surface, const TessellationOptions& options,
                        const std::array<int, 2>& tiles, bool whole_too = true) {
  Faults faults;
  const Tiling tiling = make_tiles(surface, options, tiles);
  check_seams(tiling, is_everywhere(surface), faults);
  const TriangleMesh all = welded(tiling);
  check_topology(all, false, faults);
  check_triangles(all, surface.size(), domain_width(surface), faults);
  const bool adaptive = options.scheme == MeshScheme::kAdaptive;
  double uncertified = 0, area = 0;
  for (const Tessellation& made : tiling.made) {
    uncertified += made.report.uncertified_area;
    area += made.report.area;
    if (made.mesh.triangles.empty()) continue;
    check_mesh(surface, options, made, !is_everywhere(surface), faults);
    if (!adaptive) continue;
    check_deviation(surface, made, std::max(made.report.tolerance, made.report.certified_deviation),
                    200, 1, faults);
    check_curves(surface, made, faults);
  }
  if (!whole_too) return faults.text();
  const Result<Tessellation> whole = tessellate(surface, options);
  if (!whole) return "refused as a whole: " + to_text(whole.error());
  if (whole->report.uncertified_area == 0 && uncertified > 0 && adaptive)
    faults.add("not certified in tiles", uncertified, 0);
  const std::size_t loops = open_loops(all), of_whole = open_loops(whole->mesh);
  if (loops != of_whole)
    faults.add("loops of open sides: " + std::to_string(loops) + " in tiles, " +
               std::to_string(of_whole) + " as a whole");
  std::set<std::string> names, names_of_whole;
  for (const MeshElement& e : all.elements) names.insert(e.name);
  for (const MeshElement& e : whole->mesh.elements) names_of_whole.insert(e.name);
  if (names != names_of_whole) faults.add("other elements in tiles");
  // Each is within the tolerance of one surface: areas differ by what so much of it can hold.
  if (std::fabs(area - whole->report.area) > 0.02 * area + 40 * whole->report.tolerance)
    faults.add("area", area, whole->report.area);
  return faults.text();
}

std::string all_tilings(const CompoundSurface& surface, const TessellationOptions& options) {
  std::string text;
  for (const auto& tiles : kTilings) {
    const std::string faults = tile_faults(surface, options, tiles);
    if (!faults.empty())
      text += std::to_string(tiles[0]) + "x" + std::to_string(tiles[1]) + ": " + faults;
  }
  return text;
}

class TiledFixtures : public testing::TestWithParam<const char*> {};

TEST_P(TiledFixtures, MeetToTheBit) {
  const CompoundSurface surface = fixture(GetParam());
  TessellationOptions options;
  for (const double factor : {1.0, 8.0}) {
    options.tolerance = factor * surface.program().machining.tolerance;
    EXPECT_EQ(all_tilings(surface, options), "") << factor;
  }
}

TEST_P(TiledFixtures, MeetToTheBitOnTheGrid) {
  const CompoundSurface surface = fixture(GetParam());
  TessellationOptions options;
  options.scheme = MeshScheme::kGrid;
  EXPECT_EQ(tile_faults(surface, options, {3, 2}), "");
  // A plain grid leaves out cells beside a hole, on one side of a cut as it happens.
  if (!is_everywhere(surface)) return;
  options.creases = false;
  const Tiling tiling = make_tiles(surface, options, {3, 2});
  Faults faults;
  check_seams(tiling, is_everywhere(surface), faults);
  EXPECT_EQ(faults.text(), "") << "without creases";
}

INSTANTIATE_TEST_SUITE_P(Parts, TiledFixtures,
                         testing::Values("allprims", "border", "fig6", "groups", "inch", "nobase",
                                         "pockets", "spheres", "steinmetz", "tangent"),
                         [](const testing::TestParamInfo<const char*>& of) {
                           return std::string(of.param);
                         });

// Of flush faces, which shows a sliver within rounding of another hangs on where the cells lie; so
// does whether one narrower than 1e-9 of the size is drawn together.
std::string but_for_slivers(const NamedCase& of, std::string faults) {
  if ((of.name.find("Rounded") == 0 || of.name == "BarAlongALeaningEdge") &&
      faults == "other elements in tiles\n")
    faults.clear();
  return faults;
}

class TiledCases : public testing::TestWithParam<NamedCase> {};

// Their cuts fall on walls, creases, rims, apexes and corners: most are built about the middle.
TEST_P(TiledCases, MeetToTheBit) {
  const NamedCase& one = GetParam();
  TessellationOptions options;
  options.tolerance = one.tolerance;
  const CompoundSurface surface = surface_of(one.text);
  EXPECT_EQ(but_for_slivers(one, tile_faults(surface, options, {2, 2})), "");
  EXPECT_EQ(but_for_slivers(one, tile_faults(surface, options, {4, 3})), "");
}

INSTANTIATE_TEST_SUITE_P(Named, TiledCases, testing::ValuesIn(named_cases()),
                         [](const testing::TestParamInfo<NamedCase>& of) { return of.param.name; });

class FarTiledCases : public testing::TestWithParam<NamedCase> {};

// A million millimetres away each tile is made near the origin; cuts and seams agree for all that.
// (What is a thousandth of a millimetre has only a few digits there.)
TEST_P(FarTiledCases, MeetToTheBit) {
  const NamedCase& one = GetParam();
  if (one.name == "ThousandthOfAMillimetre") return;
  TessellationOptions options;
  options.tolerance = one.tolerance;
  const CompoundSurface surface = surface_of(moved(one.text, 1e6));
  EXPECT_EQ(but_for_slivers(one, tile_faults(surface, options, {2, 2})), "");
  EXPECT_EQ(but_for_slivers(one, tile_faults(surface, options, {1, 5})), "");
  options.scheme = MeshScheme::kGrid;
  EXPECT_EQ(but_for_slivers(one, tile_faults(surface, options, {3, 2})), "") << "on the grid";
}

INSTANTIATE_TEST_SUITE_P(Named, FarTiledCases, testing::ValuesIn(named_cases()),
                         [](const testing::TestParamInfo<NamedCase>& of) { return of.param.name; });

// Everything that lies exactly on the even cuts of the domain [0, 40]² in four by two.
TEST(Tiles, CutsOnWallsCreasesAndCorners) {
  for (const std::string& text :
       {on_plane(box("A", "10,5,-1", "20,20,4"), "+A"),  // walls
        on_plane(box("A", "10,5,-5", "20,20,4"), "-A"),  // a pocket's
        on_plane(box("A", "10,10,-1", "20,20,4") + box("C", "20,20,-1", "30,30,7"), "+A+C"),
        on_plane(cylinder("A", "5,20,0", "35,20,0", "6"), "+A"),     // its axis along a cut
        on_plane(cylinder("A", "20,20,-1", "20,20,4", "10"), "+A"),  // rims touch cuts
        on_plane(cone("K", "20,20,0", "20,20,9", "10"), "+K"),       // apex where four tiles meet
        on_plane(sphere("S", "20,20,0", "12") + box("A", "10,10,-3", "20,25,4"), "+S-A")}) {
    TessellationOptions options;
    EXPECT_EQ(tile_faults(surface_of(text), options, {4, 2}), "") << text;
    EXPECT_EQ(tile_faults(surface_of(text), options, {2, 4}), "") << text;
  }
}

// More faces side by side along a cut than the lists of a cell hold: what they leave out was once
// taken for nothing.
TEST(Tiles, ManyFacesAlongACut) {
  std::string solids, expression;
  for (int k = 0; k < 24; ++k) {
    const std::string name = "K" + std::to_string(k), x = std::to_string(2 + 4 * k);
    solids += box(name, x + ",40,-1", std::to_string(4 + 4 * k) + ",60," + std::to_string(1 + k));
    expression += (k % 12 == 0 ? "\n+" : "+") + name;
  }
  const CompoundSurface surface = surface_of(on_plane(solids, expression, "0,100", "0,100"));
  TessellationOptions options;
  EXPECT_EQ(tile_faults(surface, options, {1, 2}), "");
  const Result<Tessellation> whole = tessellate(surface, options);
  ASSERT_TRUE(whole);
  EXPECT_EQ(whole->report.uncertified_area, 0);
  EXPECT_EQ(whole->mesh.elements.size(), 49u);  // a top and a wall each, and the plane
}

// A round edge goes over into its top without a crease: two curves in one line cross every cut.
TEST(Tiles, CutsThroughRoundEdges) {
  const CompoundSurface surface = surface_of(
      "SOLID-DEF\nA,4-PRIS,3\nP1,0,0,-7.5\nP2,50,50,0\n"
      "C,4-PRIS,2\nP1,21.139535,23.899866,-5\nP2,27.975198,26.985916,-5\n"
      "P3,23.860465,36.100134,-5\nP4,17.024802,33.014084,-5\nHEI,12.5\n"
      "D,4-PRIS,2\nP1,17.832297,25.149737,-5\nP2,29.22507,30.293154,-5\n"
      "P3,27.167703,34.850263,-5\nP4,15.77493,29.706846,-5\nHEI,12.5\n"
      "E,R-CYLI,1\nP1,20.110851,26.178421,7.5\nP2,26.946515,29.26447,7.5\nRAD,2.5\n"
      "F,R-CYLI,1\nP1,26.946515,29.26447,7.5\nP2,24.889149,33.821579,7.5\nRAD,2.5\n"
      "G,R-CYLI,1\nP1,27.5,50,-2.5\nP2,27.5,50,10\nRAD,2.5\n"
      "BOOLE-DEF\nA+C+D+E+F-G\nMACHI-DEF\nX-RNG,0,50\nY-RNG,0,50\nTOLER,.025\n");
  EXPECT_EQ(tile_faults(surface, TessellationOptions{}, {2, 2}), "");
}

CompoundSurface over_scan(TriangleMesh scan, const std::string& solids,
                          const std::string& expression) {
  for (Vec3& p : scan.positions) {  // of holes, used by no triangle
    if (std::isnan(p.z())) p.z() = 0;
  }
  const PartProgram program =
      program_of((solids.empty() ? "" : "SOLID-DEF\n" + solids) + "BSURF-DEF\nMESH,scan.stl\n" +
                 "BOOLE-DEF\n" + expression + "\nMACHI-DEF\nTOLER,.02\n");
  Result<CompoundSurface> surface = CompoundSurface::make(program, std::move(scan));
  if (!surface) throw std::runtime_error(to_text(surface.error()));
  return std::move(*surface);
}

// Over a scan the seams are its own sections, cut by the solids; even cuts fall on its vertices.
TEST(Tiles, OverAScanMeetToTheBit) {
  const auto relief = [](double x, double y) { return 2 * std::sin(x / 9) * std::cos(y / 7); };
  const auto with_holes = [&](double x, double y) {
    const bool hole = std::hypot(x - 30, y - 20) < 6 || std::hypot(x - 11, y - 9) < 3 || x > 52;
    return hole ? std::numeric_limits<double>::quiet_NaN() : relief(x, y);
  };
  const std::string boss = "S1,R-CYLI,2\nP1,20,20,-5\nNOR,.1,.2,1\nRAD,7\nLEN,14\n";
  const std::string pocket = "S2,SPHER\nP1,42,22,3\nRAD,9\n";
  const std::string bar = box("S3", "5,18.5,-3", "58,21.5,3");
  struct Case {
    TriangleMesh scan;
    std::string solids, expression;
    std::vector<std::array<int, 2>> tilings{{2, 2}, {3, 1}, {2, 4}};
  };
  for (const Case& each :
       {Case{height_mesh(0, 60, 61, 0, 40, 41, relief), "", "B"},
        Case{height_mesh(0, 60, 61, 0, 40, 41, relief), boss + pocket, "B+S1-S2"},
        Case{height_mesh(0, 60, 13, 0, 40, 9, relief), boss + pocket + bar, "B+S1-S2+S3"},
        Case{height_mesh(0, 60, 121, 0, 40, 81, with_holes), "", "B", {{3, 1}, {2, 4}}},
        Case{height_mesh(0, 60, 121, 0, 40, 81, with_holes), bar + boss, "B+S1+S3", {{3, 1}}}}) {
    const CompoundSurface surface = over_scan(each.scan, each.solids, each.expression);
    for (const std::array<int, 2>& tiles : each.tilings) {
      Faults faults;
      const Tiling tiling = make_tiles(surface, {}, tiles);
      check_seams(tiling, false, faults);
      const TriangleMesh all = welded(tiling);
      check_topology(all, false, faults);
      const Result<Tessellation> whole = tessellate(surface, {});
      ASSERT_TRUE(whole);
      if (open_loops(all) != open_loops(whole->mesh))
        faults.add("loops of open sides: " + std::to_string(open_loops(all)) + " in tiles, " +
                   std::to_string(open_loops(whole->mesh)) + " as a whole");
      for (const Tessellation& made : tiling.made) {
        if (made.mesh.triangles.empty()) continue;
        check_report(made, false, faults);
        check_deviation(surface, made, made.report.tolerance, 200, 1, faults);
        if (made.report.uncertified_area > 0)
          faults.add("uncertified area", made.report.uncertified_area, 0);
      }
      EXPECT_EQ(faults.text(), "") << each.expression << " of " << each.scan.triangles.size()
                                   << ", " << tiles[0] << "x" << tiles[1];
    }
  }
}

TEST(Tiles, RandomProgramsMeetToTheBit) {
  int made = 0;
  for (std::uint64_t seed = 1; seed <= 120; ++seed) {
    const CompoundSurface surface = surface_of(random_part_program(seed));
    TessellationOptions options;
    options.tolerance = 4 * surface.program().machining.tolerance;
    if (!tessellate(surface, options)) continue;  // no surface in the domain, or refused as a whole
    const std::array<int, 2>& tiles = kTilings[seed % 4];
    EXPECT_EQ(tile_faults(surface, options, tiles, false), "") << "seed " << seed;
    ++made;
  }
  EXPECT_GT(made, 100);
}

TEST(Tiles, AreClosedBlocksOnOneFloor) {
  const CompoundSurface surface = fixture("fig6");
  TessellationOptions options;
  options.solid = true;
  const Tiling tiling = make_tiles(surface, options, {2, 2});
  double volume = 0;
  std::set<double> floors;
  for (const Tessellation& made : tiling.made) {
    Faults faults;
    check_topology(made.mesh, true, faults);
    EXPECT_EQ(faults.text(), "");
    EXPECT_TRUE(made.report.watertight);
    volume += made.report.volume;
    floors.insert(made.report.bounds[0].z());
  }
  ASSERT_EQ(floors.size(), 1u);
  options.floor = *floors.begin();
  const Result<Tessellation> whole = tessellate(surface, options);
  ASSERT_TRUE(whole);
  // Both within the tolerance of the same die.
  const auto& d = whole->report.domain;
  EXPECT_NEAR(volume, whole->report.volume,
              2 * whole->report.tolerance * (d[1] - d[0]) * (d[3] - d[2]));
}

TEST(Tiles, WithoutASurfaceAreEmpty) {
  const CompoundSurface surface =
      surface_of("SOLID-DEF\n" + sphere("S", "10,10,0", "5") +
                 "BOOLE-DEF\nS\nMACHI-DEF\nX-RNG,0,40\nY-RNG,0,40\nTOLER,.01\n");
  TessellationOptions options;
  const Tiling tiling = make_tiles(surface, options, {2, 2});
  EXPECT_FALSE(tiling.at(0, 0).mesh.triangles.empty());
  EXPECT_TRUE(tiling.at(1, 1).mesh.triangles.empty());
}

}  // namespace
}  // namespace diesink::test
