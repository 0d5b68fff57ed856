// Weld, topology and repair against meshes whose counts are known, and against slower ways.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>

#include "core/mesh_tools/corner_weld.h"
#include "core/mesh_tools/polygon.h"
#include "core/mesh_tools/repair.h"
#include "core/mesh_tools/topology.h"
#include "core/mesh_tools/vertex_table.h"
#include "core/mesh_tools/weld.h"
#include "tests/support/random_mesh.h"

namespace diesink {
namespace {

using testing::append;
using testing::box_mesh;
using testing::random_mesh;
using testing::torus_mesh;
using Triangle = std::array<std::uint32_t, 3>;

// Every triangle with vertices of its own, as STL has them.
TriangleMesh soup(const TriangleMesh& mesh) {
  TriangleMesh apart;
  for (const Triangle& t : mesh.triangles) {
    const auto first = static_cast<std::uint32_t>(apart.positions.size());
    for (const std::uint32_t v : t) apart.positions.push_back(mesh.positions[v]);
    apart.triangles.push_back({first, first + 1, first + 2});
  }
  return apart;
}

// Few different values, many repeats, zeros of both signs; or so many that tables grow.
TEST(EqualPositions, AreNumberedAsInAnOrderedMap) {
  std::mt19937_64 random(1);
  for (const std::uint64_t values : {21, 201}) {
    std::vector<Vec3> positions(10'000);
    for (Vec3& p : positions) {
      const auto value = [&] {
        const auto number = static_cast<std::int64_t>(random() % values);
        return static_cast<double>(number - static_cast<std::int64_t>(values / 2)) * -0.125;
      };
      p = Vec3(value(), value(), value());
    }
    VertexTable table(1);
    const WeldMap map = weld_map(positions);
    std::map<std::array<double, 3>, std::uint32_t> known;
    std::vector<std::uint32_t> first;
    for (std::uint32_t v = 0; v < positions.size(); ++v) {
      const Vec3& p = positions[v];
      const auto [at, is_new] = known.emplace(std::array{p.x() + 0.0, p.y() + 0.0, p.z() + 0.0},
                                              static_cast<std::uint32_t>(known.size()));
      if (is_new) first.push_back(v);
      EXPECT_EQ(table.add(p), at->second);
      EXPECT_EQ(table.find(p), at->second);
      EXPECT_EQ(map.of_vertex[v], at->second);
    }
    EXPECT_EQ(table.size(), known.size());
    EXPECT_EQ(map.kept, first);
    EXPECT_EQ(table.find(Vec3(100, 0, 0)), VertexTable::kAbsent);
  }
}

// Whatever the number of threads, the waves and the growth of the tables.
TEST(CornerWeld, NumbersPositionsAsTheyFirstAppear) {
  std::mt19937_64 random(2);
  for (const int spread : {3, 40, 100'000}) {
    std::vector<Vec3> corners(3 * 70'000);
    for (Vec3& corner : corners) {
      for (int k = 0; k < 3; ++k) {
        corner[k] = static_cast<double>(static_cast<int>(random() % spread) - 1) * -0.125;
      }
    }
    std::vector<std::uint32_t> expected;
    std::vector<Vec3> positions;
    std::map<std::array<double, 3>, std::uint32_t> known;
    for (const Vec3& c : corners) {
      const std::array key{c.x() + 0.0, c.y() + 0.0, c.z() + 0.0};
      const auto [at, is_new] = known.emplace(key, static_cast<std::uint32_t>(known.size()));
      if (is_new) positions.emplace_back(key[0], key[1], key[2]);
      expected.push_back(at->second);
    }
    for (const int threads : {1, 2, 5}) {
      for (const std::size_t expect : {std::size_t{0}, known.size()}) {
        CornerWeld weld(expect, threads);
        std::vector<std::uint32_t> numbers(corners.size());
        for (std::size_t first = 0; first < corners.size();) {
          const std::size_t some = 3 * (1 + random() % (weld.wave() / 3));
          const std::size_t count = std::min(corners.size() - first, some);
          weld.add(
              [&](std::size_t begin, std::size_t end, Vec3* to) {
                std::copy_n(corners.begin() + static_cast<std::ptrdiff_t>(first + begin),
                            end - begin, to);
              },
              std::span(numbers).subspan(first, count));
          first += count;
        }
        EXPECT_EQ(weld.size(), positions.size());
        ASSERT_TRUE(numbers == expected) << spread << " " << threads;
        const std::vector<Vec3> found = weld.take();
        ASSERT_TRUE(found == positions);
        for (const Vec3& p : found) EXPECT_FALSE(std::signbit(p.x()) && p.x() == 0);
      }
    }
  }
}

// Positions that are one as floats and two as doubles, after waves in which all were floats.
TEST(CornerWeld, TellsPositionsApartThatFloatsDoNot) {
  for (const int threads : {1, 2}) {
    CornerWeld weld(0, threads);
    const auto add = [&](std::vector<Vec3> corners) {
      std::vector<std::uint32_t> numbers(corners.size());
      weld.add([&](std::size_t begin, std::size_t end,
                   Vec3* to) { std::copy(&corners[begin], &corners[0] + end, to); },
               numbers);
      return numbers;
    };
    using Numbers = std::vector<std::uint32_t>;
    std::vector<Vec3> many;
    for (int k = 0; k < 3 * 400; ++k) many.emplace_back(k, 0.5, 0.25);
    EXPECT_EQ(add(many).back(), 1199U);
    const Vec3 near(3, 0.5 + 1e-12, 0.25);
    EXPECT_EQ(add({many[3], near, many[4]}), (Numbers{3, 1200, 4}));
    EXPECT_EQ(add({near, many[3], Vec3(-0.0, 0.5, 0.25)}), (Numbers{1200, 3, 0}));
    // The tables grow: what stands in them is found again.
    for (Vec3& p : many) p.y() += 1e-13;
    EXPECT_EQ(add(many)[7], 1208U);
    EXPECT_EQ(add({many[9], near, Vec3(9, 0.5, 0.25)}), (Numbers{1210, 1200, 9}));
  }
}

TEST(Topology, DuplicatesAreThoseAfterTheFirst) {
  std::mt19937 random(3);
  for (const std::uint32_t spread : {4U, 60U, 4000U}) {
    std::vector<Triangle> triangles(120'000);
    for (Triangle& t : triangles) {
      for (std::uint32_t& v : t) v = static_cast<std::uint32_t>(random() % spread);
    }
    std::set<Triangle> met;
    std::vector<std::uint32_t> expected;
    for (std::uint32_t i = 0; i < triangles.size(); ++i) {
      Triangle key = triangles[i];
      std::sort(key.begin(), key.end());
      if (!met.insert(key).second) expected.push_back(i);
    }
    for (const int threads : {1, 2, 5}) EXPECT_EQ(find_duplicates(triangles, threads), expected);
  }
  EXPECT_TRUE(find_duplicates({}).empty());
}

TEST(Weld, PutsASoupTogetherAgain) {
  TriangleMesh torus = torus_mesh(12, 9);
  TriangleMesh mesh = soup(torus);
  const WeldReport report = weld(mesh);
  EXPECT_EQ(mesh.positions.size(), 12U * 9U);
  EXPECT_EQ(report.merged_vertices, 12U * 9U * 2U * 3U - 12U * 9U);
  EXPECT_EQ(report.collapsed_triangles, 0U);
  EXPECT_TRUE(topology_of(mesh, true).watertight);
}

TEST(Weld, ByToleranceKeepsPositionsApartAndMovesNoneFurther) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    std::mt19937_64 random(seed);
    std::vector<Vec3> positions;
    for (int i = 0; i < 300; ++i) {
      const auto value = [&] { return static_cast<double>(random() % 1000) / 100 - 5; };
      positions.emplace_back(value(), value(), seed % 2 == 0 ? 0.0 : value());
    }
    const double tolerance = 0.05 * (1 + seed % 10);
    const WeldMap map = weld_map(positions, tolerance);
    for (std::size_t i = 0; i < positions.size(); ++i) {
      const Vec3 to = positions[map.kept[map.of_vertex[i]]];
      EXPECT_LE((to - positions[i]).norm(), tolerance * (1 + 1e-12));
    }
    for (std::size_t a = 0; a < map.kept.size(); ++a) {
      for (std::size_t b = 0; b < a; ++b) {
        EXPECT_GT((positions[map.kept[a]] - positions[map.kept[b]]).norm(), tolerance);
      }
    }
  }
}

TEST(Weld, RemovesWhatCollapsesAndCarriesCurvesAlong) {
  TriangleMesh mesh = box_mesh(Vec3(0, 0, 0), Vec3(1, 1, 1e-4));
  mesh.curves.push_back({CurveKind::kCrease, {0, 0}, {0, 4, 5, 1}, true, ""});
  const WeldReport report = weld(mesh, 1e-3);
  EXPECT_EQ(report.merged_vertices, 4U);
  EXPECT_EQ(report.collapsed_triangles, 8U);
  EXPECT_EQ(mesh.triangles.size(), 4U);
  EXPECT_EQ(mesh.curves[0].vertices, (std::vector<std::uint32_t>{0, 1}));
}

TEST(Topology, OfABox) {
  const MeshTopology box = topology_of(soup(box_mesh(Vec3(-1, 2, 0), Vec3(1, 5, 4))));
  EXPECT_EQ(box.vertices, 8U);
  EXPECT_EQ(box.triangles, 12U);
  EXPECT_EQ(box.edges, 18U);
  EXPECT_EQ(box.shells, 1U);
  EXPECT_TRUE(box.watertight) << box.why_not;
  EXPECT_DOUBLE_EQ(box.volume, 24);
  EXPECT_DOUBLE_EQ(box.area, 2 * (6 + 8 + 12));
  EXPECT_EQ(box.bounds[0], Vec3(-1, 2, 0));
  EXPECT_EQ(box.bounds[1], Vec3(1, 5, 4));
}

TEST(Topology, VolumeIsTrueFarFromTheOrigin) {
  const MeshTopology box =
      topology_of(box_mesh(Vec3(5e6, 5e6, 5e6), Vec3(5e6 + 1, 5e6 + 1, 5e6 + 1)));
  EXPECT_DOUBLE_EQ(box.volume, 1);
}

TEST(Topology, OfATorusHasNoHolesAndOneShell) {
  const MeshTopology torus = topology_of(torus_mesh(24, 16));
  EXPECT_TRUE(torus.watertight);
  EXPECT_EQ(torus.shells, 1U);
  // Euler's characteristic of a torus is 0.
  EXPECT_EQ(torus.vertices + torus.triangles, torus.edges);
  EXPECT_GT(torus.volume, 0);
}

TEST(Topology, CountsHolesAndSaysWhyNot) {
  TriangleMesh torus = torus_mesh(24, 16);
  std::vector<bool> keep(torus.triangles.size(), true);
  for (const std::size_t hole : {0U, 1U, 300U, 600U})
    keep[hole] = false;  // the first two are one quadrilateral
  keep_triangles(torus, keep);
  const MeshTopology topology = topology_of(torus);
  EXPECT_FALSE(topology.watertight);
  EXPECT_EQ(topology.boundary_edges, 4U + 3U + 3U);
  EXPECT_EQ(topology.boundary_loops, 3U);
  EXPECT_EQ(topology.why_not, "10 boundary edges in 3 loops");
}

TEST(Topology, HolesThatTouchInAVertexHaveOneRimThroughIt) {
  TriangleMesh torus = torus_mesh(24, 16);
  std::vector<bool> keep(torus.triangles.size(), true);
  const std::uint32_t shared = torus.triangles[0][0];
  keep[0] = false;  // has the vertex
  for (std::size_t t = 2; t < keep.size(); ++t) {
    const Triangle& v = torus.triangles[t];
    const auto has = [&](std::uint32_t x) { return v[0] == x || v[1] == x || v[2] == x; };
    if (has(shared) && !has(torus.triangles[0][1]) && !has(torus.triangles[0][2])) {
      keep[t] = false;
      break;
    }
  }
  keep_triangles(torus, keep);
  const MeshTopology topology = topology_of(torus);
  EXPECT_EQ(topology.boundary_loops, 1U);
  EXPECT_EQ(topology.nonmanifold_vertices, 1U);
}

TEST(Topology, KnowsWhatTouches) {
  TriangleMesh corner = box_mesh(Vec3(0, 0, 0), Vec3(1, 1, 1));
  append(corner, box_mesh(Vec3(1, 1, 1), Vec3(2, 2, 2)));
  MeshTopology topology = topology_of(corner);
  EXPECT_EQ(topology.shells, 2U);
  EXPECT_EQ(topology.nonmanifold_vertices, 1U);
  EXPECT_EQ(topology.nonmanifold_edges, 0U);
  EXPECT_TRUE(topology.watertight);

  TriangleMesh edge = box_mesh(Vec3(0, 0, 0), Vec3(1, 1, 1));
  append(edge, box_mesh(Vec3(1, 1, 0), Vec3(2, 2, 1)));
  topology = topology_of(edge);
  EXPECT_EQ(topology.nonmanifold_edges, 1U);
  EXPECT_EQ(topology.nonmanifold_vertices, 0U);
  EXPECT_FALSE(topology.watertight);
  EXPECT_EQ(topology.why_not, "1 edge of more than two triangles");

  TriangleMesh turned = box_mesh(Vec3(0, 0, 0), Vec3(1, 1, 1));
  std::swap(turned.triangles[3][0], turned.triangles[3][1]);
  EXPECT_EQ(topology_of(turned).misoriented_edges, 3U);
}

TEST(Topology, CountsDegenerateFlatAndRepeatedTriangles) {
  TriangleMesh mesh = box_mesh(Vec3(0, 0, 0), Vec3(2, 2, 2));
  mesh.positions.emplace_back(1, 0, 0);
  mesh.positions.emplace_back(0, 0, 0);         // vertex 0 again
  mesh.triangles.push_back({0, 8, 1});          // on a line
  mesh.triangles.push_back({0, 9, 1});          // two corners at one place
  mesh.triangles.push_back(mesh.triangles[5]);  // again
  std::rotate(mesh.triangles.back().begin(), mesh.triangles.back().begin() + 1,
              mesh.triangles.back().end());
  const MeshTopology topology = topology_of(mesh);
  EXPECT_EQ(topology.degenerate, 1U);
  EXPECT_EQ(topology.flat, 1U);
  EXPECT_EQ(topology.duplicates, 1U);
  const OddFaces odd = odd_faces(mesh);
  EXPECT_EQ(odd.degenerate, 1U);
  EXPECT_EQ(odd.duplicates, 1U);
}

TEST(Topology, AgreesWithCountingInMaps) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    const TriangleMesh mesh = random_mesh(seed);
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<bool>> edges;
    std::set<std::set<std::uint32_t>> faces;
    std::size_t repeated = 0;
    for (const Triangle& t : mesh.triangles) {
      repeated += faces.insert({t[0], t[1], t[2]}).second ? 0 : 1;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t a = t[k], b = t[(k + 1) % 3];
        edges[{std::min(a, b), std::max(a, b)}].push_back(a < b);
      }
    }
    std::size_t boundary = 0, many = 0, wrong = 0;
    for (const auto& [edge, uses] : edges) {
      boundary += uses.size() == 1 ? 1 : 0;
      many += uses.size() > 2 ? 1 : 0;
      wrong += uses.size() == 2 && uses[0] == uses[1] ? 1 : 0;
    }
    const MeshTopology topology = topology_of(mesh, true);
    EXPECT_EQ(topology.edges, edges.size());
    EXPECT_EQ(topology.boundary_edges, boundary);
    EXPECT_EQ(topology.nonmanifold_edges, many);
    EXPECT_EQ(topology.misoriented_edges, wrong);
    EXPECT_EQ(topology.duplicates, repeated);
  }
}

TEST(Polygon, CutsConcaveOnesIntoTheirArea) {
  const std::vector<Vec3> arrow{{0, 0, 1}, {4, 0, 1}, {4, 4, 1}, {2, 1, 1}, {0, 4, 1}};
  std::vector<Triangle> triangles;
  EXPECT_TRUE(cut_polygon(arrow, triangles));
  ASSERT_EQ(triangles.size(), 3U);
  double area = 0;
  for (const Triangle& t : triangles) {
    const double twice = (arrow[t[1]] - arrow[t[0]]).cross(arrow[t[2]] - arrow[t[0]]).z();
    EXPECT_GT(twice, 0);
    area += twice / 2;
  }
  EXPECT_DOUBLE_EQ(area, 16 - 6);
}

TEST(Polygon, StarsKeepTheirAreaHoweverTheyLie) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    std::mt19937_64 random(seed);
    const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
    const std::size_t corners = 4 + random() % 30;
    std::vector<Vec3> flat;
    double expected = 0;
    for (std::size_t i = 0; i < corners; ++i) {
      const double angle = 6.283185307179586 * (static_cast<double>(i) + 0.8 * unit()) /
                           static_cast<double>(corners);
      const double radius = 0.2 + unit();
      flat.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0);
    }
    for (std::size_t i = 0; i < corners; ++i)
      expected += flat[i].cross(flat[(i + 1) % corners]).z() / 2;
    const Eigen::Quaterniond turn(unit() - 0.5, unit() - 0.5, unit() - 0.5, unit() + 0.1);
    const Mat3 pose = turn.normalized().toRotationMatrix();
    std::vector<Vec3> lying;
    for (const Vec3& p : flat) lying.emplace_back(pose * p);
    std::vector<Triangle> triangles;
    EXPECT_TRUE(cut_polygon(lying, triangles)) << seed;
    EXPECT_EQ(triangles.size(), corners - 2);
    double area = 0;
    for (const Triangle& t : triangles)
      area += (flat[t[1]] - flat[t[0]]).cross(flat[t[2]] - flat[t[0]]).z() / 2;
    EXPECT_NEAR(area, expected, 1e-12) << seed;
  }
}

TEST(Polygon, OneThatCrossesItselfIsToldAndCut) {
  const std::vector<Vec3> bow{{0, 0, 0}, {2, 2, 0}, {2, 0, 0}, {0, 1.5, 0}};
  std::vector<Triangle> triangles;
  EXPECT_FALSE(cut_polygon(bow, triangles));
  EXPECT_EQ(triangles.size(), 2U);
}

TEST(Repair, LeavesASoundMeshAlone) {
  const TriangleMesh torus = torus_mesh(12, 8);
  TriangleMesh mesh = torus;
  const RepairReport report = repair(mesh);
  EXPECT_EQ(mesh.positions, torus.positions);
  EXPECT_EQ(mesh.triangles, torus.triangles);
  EXPECT_EQ(
      report.flipped + report.split_vertices + report.filled_holes + report.removed_duplicates, 0U);
}

TEST(Repair, RestoresASpoiledTorus) {
  const MeshTopology sound = topology_of(torus_mesh(24, 16));
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::mt19937_64 random(seed);
    TriangleMesh mesh = soup(torus_mesh(24, 16));
    mesh.normals = {Vec3::UnitZ()};
    mesh.corner_normals.assign(mesh.triangles.size(), {0, 0, 0});
    for (int i = 0; i < 100; ++i) {
      Triangle& t = mesh.triangles[random() % mesh.triangles.size()];
      std::swap(t[0], t[1]);
    }
    for (int i = 0; i < 5; ++i) {
      const Triangle again = mesh.triangles[random() % 700];
      mesh.triangles.push_back(again);
      mesh.triangles.push_back({again[0], again[0], again[1]});
      mesh.corner_normals.resize(mesh.triangles.size(), {0, 0, 0});
    }
    std::vector<bool> keep(mesh.triangles.size(), true);
    for (const std::size_t hole : {0U, 1U, 300U, 600U}) keep[hole] = false;
    keep_triangles(mesh, keep);
    RepairOptions options;
    options.max_hole = 2;
    const RepairReport report = repair(mesh, options);
    EXPECT_TRUE(report.after.watertight) << to_text(report);
    EXPECT_EQ(report.after.vertices, sound.vertices);
    EXPECT_EQ(report.after.triangles, sound.triangles);
    EXPECT_EQ(report.after.shells, 1U);
    EXPECT_NEAR(report.after.volume, sound.volume, 0.02 * sound.volume);
    EXPECT_EQ(mesh.corner_normals.size(), mesh.triangles.size());
  }
}

TEST(Repair, TakesTouchingBoxesApartIntoTwoClosedOnes) {
  for (const Vec3& offset : {Vec3(1, 1, 0), Vec3(1, 1, 1)}) {  // along an edge, at a corner
    TriangleMesh mesh = box_mesh(Vec3(0, 0, 0), Vec3(1, 1, 1));
    append(mesh, box_mesh(offset, offset + Vec3(1, 1, 1)));
    const RepairReport report = repair(mesh);
    EXPECT_TRUE(report.after.watertight) << report.after.why_not;
    EXPECT_EQ(report.after.nonmanifold_edges + report.after.nonmanifold_vertices, 0U);
    EXPECT_EQ(report.after.shells, 2U);
    EXPECT_EQ(report.after.vertices, 16U);
    EXPECT_DOUBLE_EQ(report.after.volume, 2);
  }
}

TEST(Repair, TurnsAnInsideOutMeshButNotACavity) {
  TriangleMesh mesh = box_mesh(Vec3(0, 0, 0), Vec3(1, 1, 1));
  for (Triangle& t : mesh.triangles) std::swap(t[0], t[1]);
  EXPECT_EQ(repair(mesh).flipped, 12U);
  EXPECT_DOUBLE_EQ(topology_of(mesh).volume, 1);

  TriangleMesh hollow = box_mesh(Vec3(0, 0, 0), Vec3(4, 4, 4));
  TriangleMesh cavity = box_mesh(Vec3(1, 1, 1), Vec3(3, 3, 3));
  for (Triangle& t : cavity.triangles) std::swap(t[0], t[1]);
  append(hollow, cavity);
  EXPECT_EQ(repair(hollow).flipped, 0U);
  EXPECT_DOUBLE_EQ(topology_of(hollow).volume, 64 - 8);
}

TEST(Repair, LeavesTheRimOfAnOpenSheet) {
  TriangleMesh mesh = box_mesh(Vec3(0, 0, 0), Vec3(10, 10, 1));
  mesh.triangles.resize(2);
  const RepairReport report = repair(mesh);
  EXPECT_EQ(report.filled_holes, 0U);
  EXPECT_EQ(mesh.triangles.size(), 2U);
}

TEST(Repair, NeverMakesRandomMeshesWorse) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    TriangleMesh mesh = random_mesh(seed);
    const RepairReport report = repair(mesh);
    EXPECT_EQ(report.after.degenerate, 0U);
    EXPECT_EQ(report.after.nonmanifold_vertices, 0U) << seed;
    EXPECT_EQ(mesh.corner_normals.size(), mesh.triangles.size());
    for (const Triangle& t : mesh.triangles) {
      for (const std::uint32_t v : t) ASSERT_LT(v, mesh.positions.size());
    }
    EXPECT_EQ(mesh.vertex_colors.size(), mesh.positions.size());
  }
}

TEST(Repair, AHoleAroundASheetRepeatsNoCornerTriangle) {
  // A square sheet: its border is one hole, and each of two corners is a triangle of its own.
  TriangleMesh sheet;
  for (int j = 0; j < 4; ++j) {
    for (int i = 0; i < 4; ++i) sheet.positions.emplace_back(i, j, i * j % 2);
  }
  for (std::uint32_t j = 0; j < 3; ++j) {
    for (std::uint32_t i = 0; i < 3; ++i) {
      const std::uint32_t a = j * 4 + i;
      sheet.triangles.push_back({a, a + 1, a + 4});
      sheet.triangles.push_back({a + 1, a + 5, a + 4});
    }
  }
  RepairOptions options;
  options.max_hole = 100;
  const RepairReport report = repair(sheet, options);
  EXPECT_EQ(report.filled_holes, 1U);
  EXPECT_EQ(report.after.duplicates, 0U);
  EXPECT_TRUE(report.after.watertight) << report.after.why_not;
}

}  // namespace
}  // namespace diesink
