// Degenerate dies, each proved in every way it can be meshed.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

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

INSTANTIATE_TEST_SUITE_P(Named, NamedCases, testing::ValuesIn(named_cases()),
                         [](const testing::TestParamInfo<NamedCase>& of) { return of.param.name; });

}  // namespace
}  // namespace diesink::test
