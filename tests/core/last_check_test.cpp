// Meshes broken on purpose: the last check tells every one.
// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/last_check.h"

#include <gtest/gtest.h>

#include "tests/support/load_part.h"
#include "tests/support/mesh_checks.h"
#include "tests/support/named_cases.h"

namespace diesink::test {
namespace {

// A small dome far from the middle of anything beside a larger one and a pocket.
std::string part_with(const std::string& expression) {
  return on_plane(sphere("S", "14,14,0", "8") + sphere("T", "31.3,8.9,0", ".7") +
                      box("A", "22,22,-3", "36,34,9"),
                  expression);
}

Tessellation mesh_of(const CompoundSurface& surface, MeshScheme scheme = MeshScheme::kAdaptive) {
  TessellationOptions options;
  options.tolerance = 0.01;
  options.scheme = scheme;
  Result<Tessellation> made = tessellate(surface, options);
  if (!made) throw std::runtime_error(to_text(made.error()));
  return std::move(*made);
}

// What the check adds to a mesh, after `breaking` it.
template <class Break>
TessellationReport checked(Break breaking, MeshScheme scheme = MeshScheme::kAdaptive) {
  const CompoundSurface surface = surface_of(part_with("+S+T-A"));
  Tessellation made = mesh_of(surface, scheme);
  made.report.uncertified_area = 0;
  breaking(made.mesh);
  last_check(surface, 1, made);
  return made.report;
}

std::size_t a_triangle_of(const TriangleMesh& mesh, const std::string& element) {
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (mesh.elements[mesh.triangle_element[t]].name == element) return t;
  }
  throw std::runtime_error("no " + element);
}

TEST(LastCheck, FindsNothingWrongWithWhatIsRight) {
  for (const MeshScheme scheme : {MeshScheme::kAdaptive, MeshScheme::kGrid}) {
    const TessellationReport report = checked([](TriangleMesh&) {}, scheme);
    EXPECT_EQ(report.doubt_count, 0u);
    EXPECT_EQ(report.uncertified_area, 0);
  }
}

// Less than the tolerance off, and yet no point of the curve.
TEST(LastCheck, TellsACurveThatIsOffItsFace) {
  const TessellationReport report = checked([](TriangleMesh& mesh) {
    const auto crease = std::find_if(mesh.curves.begin(), mesh.curves.end(), [](const auto& c) {
      return c.kind == CurveKind::kCrease && c.vertices.size() > 4;
    });
    mesh.positions[crease->vertices[2]].z() += 0.003;
  });
  ASSERT_EQ(report.doubt_count, 1u);
  EXPECT_EQ(report.doubts[0].what, "a curve is off its face there");
  EXPECT_GT(report.uncertified_area, 1e-5);
}

TEST(LastCheck, TellsATriangleThatLooksDown) {
  const TessellationReport report = checked([](TriangleMesh& mesh) {
    auto& t = mesh.triangles[a_triangle_of(mesh, "S.surface")];
    std::swap(t[0], t[1]);
  });
  ASSERT_EQ(report.doubt_count, 1u);
  EXPECT_EQ(report.doubts[0].what, "a triangle that looks down");
  EXPECT_EQ(report.doubts[0].element, "S.surface");
  EXPECT_GT(report.uncertified_area, 0);
  EXPECT_EQ(report.doubts[0].area, report.uncertified_area);
}

TEST(LastCheck, TellsATriangleWithoutArea) {
  const TessellationReport report = checked([](TriangleMesh& mesh) {
    auto& t = mesh.triangles[a_triangle_of(mesh, "B")];
    mesh.positions.push_back(0.5 * (mesh.positions[t[0]] + mesh.positions[t[1]]));
    t[2] = static_cast<std::uint32_t>(mesh.positions.size() - 1);
  });
  ASSERT_GE(report.doubt_count, 1u);
  EXPECT_EQ(report.doubts[0].what, "a triangle without area");
  EXPECT_GT(report.uncertified_area, 0);
}

TEST(LastCheck, TellsAVertexOffItsFace) {
  const TessellationReport report = checked([](TriangleMesh& mesh) {
    mesh.positions[mesh.triangles[a_triangle_of(mesh, "S.surface")][0]].z() += 0.5;
  });
  ASSERT_GE(report.doubt_count, 1u);
  EXPECT_EQ(report.doubts[0].what, "the surface is another there");
}

TEST(LastCheck, TellsAnotherElement) {
  const TessellationReport report = checked([](TriangleMesh& mesh) {
    // The pocket's floor is said to be the plane.
    const std::uint32_t base = mesh.triangle_element[a_triangle_of(mesh, "B")];
    const std::uint32_t floor = mesh.triangle_element[a_triangle_of(mesh, "A.face1")];
    for (std::uint32_t& e : mesh.triangle_element) e = e == floor ? base : e;
  });
  ASSERT_GE(report.doubt_count, 1u);
  EXPECT_NEAR(report.uncertified_area, 14 * 12, 1e-9);
}

// The mesh of a part without the small dome, against the part with it.
TEST(LastCheck, MissesAFaceThatWasLost) {
  for (const MeshScheme scheme : {MeshScheme::kAdaptive, MeshScheme::kGrid}) {
    Tessellation made = mesh_of(surface_of(part_with("+S-A")), scheme);
    made.report.uncertified_area = 0;
    last_check(surface_of(part_with("+S+T-A")), 1, made);
    ASSERT_GE(made.report.doubt_count, 1u);
    EXPECT_NEAR(made.report.doubts[0].place.x(), 31.3, 0.7);
    EXPECT_NEAR(made.report.doubts[0].place.y(), 8.9, 0.7);
    EXPECT_EQ(made.report.doubts[0].element, "B");
  }
}

TEST(LastCheck, MissesATriangleThatWasLost) {
  const TessellationReport report = checked([](TriangleMesh& mesh) {
    // All of the pocket's floor.
    const std::uint32_t floor = mesh.triangle_element[a_triangle_of(mesh, "A.face1")];
    TriangleMesh left = mesh;
    left.triangles.clear();
    left.triangle_element.clear();
    left.corner_normals.clear();
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      if (mesh.triangle_element[t] == floor) continue;
      left.triangles.push_back(mesh.triangles[t]);
      left.triangle_element.push_back(mesh.triangle_element[t]);
      left.corner_normals.push_back(mesh.corner_normals[t]);
    }
    mesh = left;
  });
  ASSERT_GE(report.doubt_count, 1u);
  EXPECT_EQ(report.doubts[0].what, "no triangle over the surface");
}

TEST(LastCheck, TellsTheSameForAnyNumberOfThreads) {
  const CompoundSurface surface = surface_of(part_with("+S+T-A"));
  const Tessellation broken = mesh_of(surface_of(part_with("+T-A")));
  Tessellation one = broken, four = broken;
  last_check(surface, 1, one);
  last_check(surface, 4, four);
  ASSERT_GT(one.report.doubt_count, 0u);
  EXPECT_EQ(one.report.doubt_count, four.report.doubt_count);
  EXPECT_EQ(one.report.uncertified_area, four.report.uncertified_area);
  for (std::size_t k = 0; k < one.report.doubts.size(); ++k)
    EXPECT_EQ(one.report.doubts[k].place, four.report.doubts[k].place);
}

}  // namespace
}  // namespace diesink::test
