// Degenerate dies, each proved in every way it can be meshed.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "tests/support/load_part.h"
#include "tests/support/mesh_proof.h"
#include "tests/support/named_cases.h"

namespace diesink::test {
namespace {

class NamedCases : public testing::TestWithParam<NamedCase> {};

std::string prove_case(const NamedCase& given, MeshScheme scheme, bool solid) {
  ProofOptions options;
  options.samples = 1500;
  options.tessellation.tolerance = given.tolerance;
  options.tessellation.scheme = scheme;
  options.tessellation.solid = solid;
  return prove(surface_of(given.text), options);
}

TEST_P(NamedCases, Sheet) { EXPECT_EQ(prove_case(GetParam(), MeshScheme::kAdaptive, false), ""); }
TEST_P(NamedCases, Solid) { EXPECT_EQ(prove_case(GetParam(), MeshScheme::kAdaptive, true), ""); }
TEST_P(NamedCases, GridSolid) { EXPECT_EQ(prove_case(GetParam(), MeshScheme::kGrid, true), ""); }

// Least height of a triangle, of the size of the part.
double least_height(const NamedCase& given) {
  TessellationOptions options;
  options.tolerance = given.tolerance;
  const CompoundSurface surface = surface_of(given.text);
  const Result<Tessellation> made = tessellate(surface, options);
  if (!made) return 0;
  double least = 1e300;
  for (const auto& t : made->mesh.triangles) {
    const Vec3 &a = made->mesh.positions[t[0]], &b = made->mesh.positions[t[1]],
               &c = made->mesh.positions[t[2]];
    const double longest =
        std::sqrt(std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()}));
    least = std::min(least, (b - a).cross(c - a).norm() / longest);
  }
  return least / surface.size();
}

// Rounding gives two curves that touch two crossings side by side, and a silhouette two heights:
// neither may become a triangle.
TEST(DegenerateDies, NoSliverWhereCurvesTouch) {
  for (const NamedCase& given : named_cases()) {
    for (const char* name :
         {"NoBaseTwoTouchingDiscs", "PlanShadowsTouchInAPoint", "CylindersSideBySide"}) {
      if (given.name != name) continue;
      EXPECT_GT(least_height(given), 1e-6) << name;
    }
  }
}

// A millionth of the domain: a cell of 2^-22 of it is wider than what this tolerance does not see.
TEST(DegenerateDies, TenMetresAtAHundredth) {
  const CompoundSurface surface = surface_of(
      "SOLID-DEF\nS,SPHER,1\nP1,4000,5000,0\nRAD,200\nA,R-CYLI,1\nP1,4100,5000,-100\n"
      "P2,4100,5000,300\nRAD,100\nBSURF-DEF\nPLANE,0\nBOOLE-DEF\nB+S+A\n"
      "MACHI-DEF\nX-RNG,0,10000\nY-RNG,0,10000\n");
  TessellationOptions options;
  options.tolerance = 0.01;
  const Result<Tessellation> made = tessellate(surface, options);
  ASSERT_TRUE(made);
  EXPECT_EQ(made->report.uncertified_area, 0);
  EXPECT_LE(made->report.certified_deviation, 0.01);
}

INSTANTIATE_TEST_SUITE_P(Named, NamedCases, testing::ValuesIn(named_cases()),
                         [](const testing::TestParamInfo<NamedCase>& of) { return of.param.name; });

}  // namespace
}  // namespace diesink::test
