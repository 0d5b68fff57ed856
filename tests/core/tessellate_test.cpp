// What holds of every mesh the tessellator makes: the fixtures, random programs, threads, spacing,
// and volumes known in closed form.
// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/tessellate.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <sstream>

#include "tests/support/load_part.h"
#include "tests/support/mesh_proof.h"
#include "tests/support/named_cases.h"

namespace diesink::test {
namespace {

class Fixtures : public testing::TestWithParam<const char*> {};

TEST_P(Fixtures, AreProved) {
  const CompoundSurface surface = fixture(GetParam());
  ProofOptions options;
  options.samples = 1000;
  for (const bool solid : {false, true}) {
    options.tessellation.solid = solid;
    for (const double factor : {1.0, 8.0}) {
      options.tessellation.scheme = MeshScheme::kAdaptive;
      options.tessellation.tolerance = factor * surface.program().machining.tolerance;
      EXPECT_EQ(prove(surface, options), "") << (solid ? "solid " : "sheet ") << factor;
    }
    options.tessellation.scheme = MeshScheme::kGrid;
    EXPECT_EQ(prove(surface, options), "") << (solid ? "solid grid" : "grid");
  }
}

TEST_P(Fixtures, GiveTheSameBytesForAnyThreads) {
  const CompoundSurface surface = fixture(GetParam());
  TessellationOptions options;
  options.solid = true;
  options.threads = 1;
  const Result<Tessellation> one = tessellate(surface, options);
  ASSERT_TRUE(one);
  for (const int threads : {2, 7}) {
    options.threads = threads;
    const Result<Tessellation> many = tessellate(surface, options);
    ASSERT_TRUE(many);
    EXPECT_TRUE(same_bytes(one->mesh, many->mesh)) << threads;
    EXPECT_EQ(one->report.certified_deviation, many->report.certified_deviation);
    EXPECT_EQ(one->report.uncertified_area, many->report.uncertified_area);
  }
}

INSTANTIATE_TEST_SUITE_P(Parts, Fixtures,
                         testing::Values("allprims", "border", "fig6", "groups", "inch", "nobase",
                                         "spheres"),
                         [](const testing::TestParamInfo<const char*>& of) {
                           return std::string(of.param);
                         });

// The text with every X-INT and Y-INT statement replaced.
std::string with_interval(const std::string& text, const std::string& interval) {
  std::string out;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("X-INT") || line.starts_with("Y-INT"))
      line = line.substr(0, 5) + "," + interval;
    out += line + '\n';
  }
  return out;
}

TEST(Tessellate, DoesNotDependOnTheGrid) {
  const std::string text = part_text("fig6");
  TessellationOptions options;
  const Result<Tessellation> fine = tessellate(surface_of(with_interval(text, "0.1")), options);
  const Result<Tessellation> coarse = tessellate(surface_of(with_interval(text, "17")), options);
  ASSERT_TRUE(fine && coarse);
  EXPECT_TRUE(same_bytes(fine->mesh, coarse->mesh));
}

double volume_of(const std::string& text, double tolerance, std::string* faults = nullptr) {
  const CompoundSurface surface = surface_of(text);
  ProofOptions options;
  options.tessellation.solid = true;
  options.tessellation.floor = -20;
  options.tessellation.tolerance = tolerance;
  const Result<Tessellation> made = tessellate(surface, options.tessellation);
  if (!made) return -1;
  if (faults) *faults = faults_of(surface, options, *made);
  return made->report.volume;
}

// What is added to 40 x 40 x 20, against the body's own volume; a deviation of t over its area can
// change no more than their product.
TEST(Tessellate, VolumesAreThoseOfTheBodies) {
  constexpr double kPlate = 40.0 * 40 * 20, kPi = std::numbers::pi;
  struct Row {
    const char* what;
    std::string text;
    double volume, area;
  };
  const Row rows[] = {
      {"hemisphere", on_plane(sphere("S", "20,20,0", "8"), "+S"), 2 * kPi * 512 / 3, 2 * kPi * 64},
      {"pocket", on_plane(sphere("S", "20,20,0", "8"), "-S"), -2 * kPi * 512 / 3, 2 * kPi * 64},
      // Vertical lines fill what lies under the sphere.
      {"sphere", on_plane(sphere("S", "20,20,8", "8"), "+S"), kPi * 512 + 2 * kPi * 512 / 3,
       4 * kPi * 64},
      {"upright cylinder", on_plane(cylinder("A", "20,20,-1", "20,20,5", "7"), "+A"), kPi * 49 * 5,
       kPi * 49 + 14 * kPi * 5},
      {"cone", on_plane(cone("K", "20,20,0", "20,20,12", "9"), "+K"), kPi * 81 * 4, kPi * 9 * 15},
      {"box", on_plane(box("A", "5,5,-1", "30,30,4"), "+A"), 625 * 4, 0},
      {"box pocket", on_plane(box("A", "5,5,-3", "30,30,4"), "-A"), -625 * 3, 0},
  };
  for (const Row& row : rows) {
    for (const double tolerance : {0.05, 0.005}) {
      std::string faults;
      const double added = volume_of(row.text, tolerance, &faults) - kPlate;
      EXPECT_EQ(faults, "") << row.what;
      EXPECT_NEAR(added, row.volume, tolerance * row.area + 1e-9 * kPlate) << row.what;
    }
  }
}

TEST(Tessellate, FlatFacesTakeFewTriangles) {
  TessellationOptions options;
  const Result<Tessellation> made =
      tessellate(surface_of(on_plane(box("A", "5,5,-1", "30,30,4"), "+A")), options);
  ASSERT_TRUE(made);
  EXPECT_LT(made->mesh.triangles.size(), 400u);
  EXPECT_LT(made->report.certified_deviation, 1e-9);
}

// A triangle that keeps the tolerance t on a sphere of radius R with its vertices on it has a
// circle of at most sqrt(2 R t) and so an area of at most 2.598 R t: no such mesh has fewer than
// the area over that. Ours, whose vertices stand off, takes no more on the whole than stated.
TEST(Tessellate, TakesFewTriangles) {
  struct Row {
    const char* part;
    double tolerance;
    std::size_t most;
  };
  for (const Row& row :
       {Row{"fig6", 0.02, 1950}, Row{"fig6", 0.001, 25'000}, Row{"pockets", 0.01, 95'000}}) {
    TessellationOptions options;
    options.tolerance = row.tolerance;
    const CompoundSurface surface = fixture(row.part);
    const Result<Tessellation> made = tessellate(surface, options);
    ASSERT_TRUE(made) << row.part;
    EXPECT_LE(made->mesh.triangles.size(), row.most) << row.part << ' ' << row.tolerance;
    EXPECT_LE(made->report.certified_deviation, row.tolerance);
    EXPECT_EQ(made->report.uncertified_area, 0);
  }
  for (const double tolerance : {0.02, 0.002}) {
    TessellationOptions options;
    options.tolerance = tolerance;
    const Result<Tessellation> made =
        tessellate(surface_of(on_plane(sphere("S", "20,20,0", "12"), "+S")), options);
    ASSERT_TRUE(made);
    for (const ElementReport& e : made->report.elements) {
      if (e.type != "SPHER" || e.area < 1) continue;
      EXPECT_LE(static_cast<double>(e.triangles), 1.2 * e.area / (2.598 * 12 * tolerance))
          << tolerance;
    }
  }
}

// The least angle in space of the triangles of the paper's die, the walls' too.
TEST(Tessellate, AnglesOfFig6AreNotSmall) {
  const CompoundSurface surface = fixture("fig6");
  for (const double tolerance : {0.02, 0.001}) {
    TessellationOptions options;
    options.tolerance = tolerance;
    const Result<Tessellation> made = tessellate(surface, options);
    ASSERT_TRUE(made);
    std::vector<double> least;
    for (const auto& t : made->mesh.triangles) {
      double angle = 180;
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3& p = made->mesh.positions[t[k]];
        const Vec3 u = made->mesh.positions[t[(k + 1) % 3]] - p,
                   v = made->mesh.positions[t[(k + 2) % 3]] - p;
        angle = std::min(angle, std::atan2(u.cross(v).norm(), u.dot(v)) * 180 / std::numbers::pi);
      }
      least.push_back(angle);
    }
    std::sort(least.begin(), least.end());
    const auto quantile = [&](double q) {
      return least[static_cast<std::size_t>(q * static_cast<double>(least.size() - 1))];
    };
    EXPECT_GT(least.front(), 1) << tolerance;
    EXPECT_GE(quantile(0.01), 10) << tolerance;
    EXPECT_GE(quantile(0.05), 13) << tolerance;
    EXPECT_GE(quantile(0.5), 37) << tolerance;
  }
}

// A plate with a hole and a box's top: a few triangles a corner or a chord of the rim, which grow
// away from it.
TEST(Tessellate, FlatFacesTakeAFewTrianglesAChord) {
  TessellationOptions options;
  options.tolerance = 0.01;
  const Result<Tessellation> made =
      tessellate(surface_of(on_plane(cylinder("A", "20,20,-2", "20,20,1", "9"), "-A")), options);
  ASSERT_TRUE(made);
  // A chord of the rim sags by l² / 8 R.
  const double chords = 2 * std::numbers::pi * 9 / std::sqrt(8 * 9 * 0.01);
  for (const ElementReport& e : made->report.elements) {
    if (e.name == "B" || e.name.ends_with(".bottom")) {
      EXPECT_LE(static_cast<double>(e.triangles), 3.5 * chords) << e.name;
    }
  }
  options.tolerance = 0.001;  // straight borders do not care
  const Result<Tessellation> box_only =
      tessellate(surface_of(on_plane(box("A", "5,5,-1", "30,30,4"), "+A")), options);
  ASSERT_TRUE(box_only);
  EXPECT_LT(box_only->mesh.triangles.size(), 150u);
}

TEST(TessellationReport, ADoubtfulPlaceDoesNotCountForTheRest) {
  TessellationReport report;
  report.tolerance = 0.01;
  report.certified_deviation = 0.004;
  EXPECT_EQ(report.deviation_where_certified(), 0.004);
  report.add_doubt(Vec3::Zero(), "B", "there", 1e-3);
  EXPECT_EQ(report.deviation_where_certified(), 0.004);
  report.certified_deviation = 1e4;
  EXPECT_EQ(report.deviation_where_certified(), 0.01);
}

TEST(Tessellate, RefusesATolerancePastCoordinates) {
  const CompoundSurface surface = surface_of(
      "SOLID-DEF\nS,SPHER\nP1,50,50,0\nRAD,30\nBSURF-DEF\nPLANE,0\nBOOLE-DEF\nB+S\nMACHI-DEF\n"
      "X-RNG,0,100\nY-RNG,0,100\nTOLER,.1\n");
  TessellationOptions options;
  options.tolerance = 1e-30;
  const Result<Tessellation> made = tessellate(surface, options);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, ErrorCode::kInput);
  EXPECT_NE(made.error().message.find("ask for 1e-09 or more"), std::string::npos);
}

TEST(Tessellate, RefusesAFloorThatIsNotBelow) {
  TessellationOptions options;
  options.solid = true;
  options.floor = 1;
  EXPECT_FALSE(tessellate(surface_of(on_plane(sphere("S", "20,20,0", "8"), "+S")), options));
}

// Far fewer than the soak's.
TEST(Tessellate, RandomProgramsAreProved) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    RandomProgramOptions program;
    program.solids = 5;
    program.base = RandomBase::kPlane;
    program.groups = false;
    ProofOptions options;
    options.samples = 500;
    options.seed = seed;
    options.tessellation.tolerance = 0.1;
    options.tessellation.solid = seed % 2 == 0;
    EXPECT_EQ(prove(surface_of(random_part_program(seed, program)), options), "") << seed;
  }
}

// Random points of every element against its own bound: of walls and of faces of the base by the
// ball of that radius, which has to reach the surface; of other faces by the distance to their own
// plane or quadric, to first order (hence the hundredth). Bounds are no more than a few times what
// they bound.
TEST(Tessellate, DeviationsOfElementsAreTheirOwn) {
  struct Part {
    const char* what;
    CompoundSurface surface;
    double tolerance;
  };
  std::vector<Part> parts;
  for (const char* name : {"fig6", "allprims", "spheres"})
    parts.push_back({name, fixture(name), 0.05});
  parts.push_back(
      {"walls",
       surface_of(on_plane(sphere("S", "14,20,6", "7") + cylinder("A", "28,20,-1", "30,20,9", "6") +
                               cylinder("C", "31,7,-4", "31,7,9", "5"),
                           "+S+A-C")),
       0.03});
  int walls = 0, faces = 0;
  for (const Part& part : parts) {
    TessellationOptions options;
    options.tolerance = part.tolerance;
    options.solid = true;
    const Result<Tessellation> made = tessellate(part.surface, options);
    ASSERT_TRUE(made) << part.what;
    const TriangleMesh& mesh = made->mesh;
    std::map<std::string, Label> labels;
    for (int row = 0; row < part.surface.row_count(); ++row) {
      const int number = part.surface.surface_of_row(row);
      if (number == 0) {
        labels.emplace("B", make_label(row, 0));
        continue;
      }
      for (const std::uint8_t face :
           face_numbers(part.surface.program().solids[static_cast<std::size_t>(number - 1)].body))
        labels.emplace(part.surface.element_name(make_label(row, face)), make_label(row, face));
    }
    std::vector<double> worst(mesh.elements.size(), 0);
    Random random(11);
    Tally off;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const std::uint32_t e = mesh.triangle_element[t];
      const ElementRole role = role_of(mesh, t);
      if (role == ElementRole::kFloor || role == ElementRole::kSkirt) continue;
      const double bound = made->report.elements[e].max_deviation;
      const auto& v = mesh.triangles[t];
      const Vec3 &a = mesh.positions[v[0]], &b = mesh.positions[v[1]], &c = mesh.positions[v[2]];
      for (int k = 0; k < 2; ++k) {
        double u = k == 0 ? 1.0 / 3 : random.uniform(0, 1),
               w = k == 0 ? 1.0 / 3 : random.uniform(0, 1);
        if (u + w > 1) {
          u = 1 - u;
          w = 1 - w;
        }
        const Vec3 p = a + u * (b - a) + w * (c - a);
        const auto label = labels.find(mesh.elements[e].name);
        if (role == ElementRole::kWall) {
          // (A silhouette counts as inside to some 1e-11 of the size.)
          const double ball = bound * (1 + 1e-6) + 1e-9 * part.surface.size();
          if (t % 5 == 0 && !surface_within(part.surface, p, ball)) off(p);
          continue;
        }
        ASSERT_TRUE(label != labels.end()) << mesh.elements[e].name;
        worst[e] = std::max(worst[e], face_distance(part.surface, label->second, p));
      }
    }
    EXPECT_EQ(off.count, 0u) << part.what << " first at " << off.first.transpose();
    for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
      const ElementReport& told = made->report.elements[e];
      walls += told.name.ends_with(".wall") && told.max_deviation > 0 ? 1 : 0;
      EXPECT_LE(told.max_deviation, part.tolerance) << part.what << ' ' << told.name;
      // Beside an arc the chord's bound counts, not the sum (docs/tessellation.md).
      EXPECT_LE(worst[e], 1.01 * told.max_deviation + 1e-11 * part.surface.size())
          << part.what << ' ' << told.name;
      if (worst[e] > 0.1 * part.tolerance) {
        EXPECT_GE(worst[e], 0.3 * told.max_deviation) << part.what << ' ' << told.name;
        ++faces;
      }
    }
  }
  EXPECT_GE(walls, 5);
  EXPECT_GE(faces, 10);
  // The wall of an upright cylinder is off by the sag of its chords, no less.
  TessellationOptions options;
  options.tolerance = 0.03;
  const Result<Tessellation> made =
      tessellate(surface_of(on_plane(cylinder("A", "20,20,-1", "20,20,6", "8"), "+A")), options);
  ASSERT_TRUE(made);
  for (std::size_t e = 0; e < made->mesh.elements.size(); ++e) {
    if (made->mesh.elements[e].name != "A.wall") continue;
    double sag = 0;
    for (std::size_t t = 0; t < made->mesh.triangles.size(); ++t) {
      if (made->mesh.triangle_element[t] != e) continue;
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3 m = 0.5 * (made->mesh.positions[made->mesh.triangles[t][k]] +
                              made->mesh.positions[made->mesh.triangles[t][(k + 1) % 3]]);
        sag = std::max(sag, 8 - std::hypot(m.x() - 20, m.y() - 20));
      }
    }
    EXPECT_GT(sag, 0.005);
    EXPECT_LE(sag, made->report.elements[e].max_deviation * (1 + 1e-9));
    EXPECT_GE(sag, 0.5 * made->report.elements[e].max_deviation);
  }
}

// The border of a warped base is curved in plan: its chords keep the tolerance too.
TEST(Tessellate, FollowsTheBorderOfAWarpedBase) {
  for (const std::uint64_t seed : {2u, 4u}) {
    RandomProgramOptions program;
    program.solids = 1;
    program.base = RandomBase::kFerguson;
    program.groups = false;
    ProofOptions options;
    options.tessellation.tolerance = 0.03;
    options.tessellation.solid = true;
    EXPECT_EQ(prove(surface_of(random_part_program(seed, program)), options), "") << seed;
  }
}

}  // namespace
}  // namespace diesink::test
