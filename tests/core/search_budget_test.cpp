// Searches that are given up: what they leave is told, and the mesh is whole.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "core/tessellate/line_changes.h"
#include "core/tessellate/tessellate.h"
#include "tests/support/load_part.h"
#include "tests/support/mesh_proof.h"
#include "tests/support/named_cases.h"

namespace diesink::test {
namespace {

std::string text_of(const std::string& name) {
  for (const NamedCase& given : named_cases()) {
    if (given.name == name) return given.text;
  }
  ADD_FAILURE() << name;
  return {};
}

Tessellation solid_of(const CompoundSurface& surface, const SearchBudget& budget, int threads) {
  TessellationOptions options;
  options.solid = true;
  options.threads = threads;
  options.budget = budget;
  Result<Tessellation> made = tessellate(surface, options);
  EXPECT_TRUE(made) << to_text(made.error());
  return made ? std::move(*made) : Tessellation{};
}

// With the budget given up the solid is closed, its doubts are told, and threads do not matter.
void expect_told(const std::string& name, const SearchBudget& small) {
  const CompoundSurface surface = surface_of(text_of(name));
  EXPECT_EQ(solid_of(surface, {}, 1).report.uncertified_area, 0) << name;
  const Tessellation told = solid_of(surface, small, 1);
  EXPECT_TRUE(told.report.watertight) << name;
  EXPECT_GT(told.report.uncertified_area, 0) << name;
  EXPECT_GT(told.report.doubt_count, 0U) << name;
  EXPECT_TRUE(same_bytes(told.mesh, solid_of(surface, small, 2).mesh)) << name;
}

TEST(SearchBudget, CellsOfAPartOfTheTree) {
  SearchBudget small;
  small.cells = 40;
  for (const char* name : {"SphereInSphereTouching", "SpheresTouchingRoundAHole", "TinyPeg",
                           "PyramidsMeetingInAnApex", "IslandInAPocket"})
    expect_told(name, small);
}

TEST(SearchBudget, CellsAddedWhereBordersDoNotJoin) {
  SearchBudget small;
  small.added = 0;
  for (const char* name :
       {"SpheresSideBySide", "SpheresTouchingRoundAHole", "ThreeSpheresThroughOnePoint"})
    expect_told(name, small);
}

// A line that runs along the crossing of two spheres: over its whole length nothing is settled.
TEST(SearchBudget, PiecesOfALineAlongACrossing) {
  const CompoundSurface surface =
      surface_of(on_plane(sphere("S", "20,16,0", "8") + sphere("T", "20,24,0", "8"), "+S+T"));
  const CompoundSurface::Impl& impl = surface.impl();
  const std::vector<BodyVertices> vertices = body_vertices(impl);
  std::vector<std::uint32_t> steps;
  impl.index.over({0, 40, 0, 40}, steps);
  LineLimits limits;
  limits.flat = 1e-6;
  limits.least = 1e-3;
  const auto find = [&](double y, std::size_t most) {
    limits.most = most;
    return ChangeSearch(impl, vertices, limits).find({0, y}, {40, y}, steps);
  };
  const LineFinding all = find(20, 1'000'000), few = find(20, 1000), one = find(20, 1);
  EXPECT_GT(all.unsettled_area, 0);
  EXPECT_GT(few.unsettled_area, 10 * all.unsettled_area);  // in longer pieces
  EXPECT_GT(one.unsettled_area, few.unsettled_area);
  for (const LineFinding& found : {all, few, one}) {
    EXPECT_EQ(found.unsettled_place.y(), 20);
    Label label = impl.evaluate_face(0, 20).label;
    for (const LineChange& change : found.changes) {
      EXPECT_EQ(change.low, label);
      label = change.high;
    }
    EXPECT_EQ(label, impl.evaluate_face(40, 20).label);
  }
  EXPECT_EQ(find(21, 1000).changes.size(), 2U);
  EXPECT_EQ(find(21, 1000).unsettled_area, 0);
}

// A cylinder of hundredths of a millimetre: what its rim is held to is a length, 1e-9 of the size
// here, not the number that its discriminant happens to have.
TEST(SearchBudget, RimsOfTinyBodiesAreSettled) {
  const CompoundSurface surface = surface_of(
      "SOLID-DEF\nS,ECYLI,2\nP1,.00085192044,.00067721420,.000021561136\nNOR,.005657845,.505711415,"
      "-.588843948\nLVE,-.702610449,.629248495,.357976521\nL-R,.0000489119963\nS-R,.0000177938730\n"
      "LEN,.0000791197285\nBSURF-DEF\nPLANE,0\nBOOLE-DEF\nB+S\nMACHI-DEF\nX-RNG,0,.001\n"
      "Y-RNG,0,.001\nTOLER,.0000001\n");
  const CompoundSurface::Impl& impl = surface.impl();
  std::size_t near = 0;
  for (const CompoundStep& step : impl.steps) {
    if (step.kind != BooleanStep::Kind::kTerm || step.solid < 0) continue;
    for (const double along : {7.52e-4, 7.5381634e-4, 7.56e-4}) {
      BodyOver body;
      for (double x = 8.0e-4; x < 8.4e-4; x += 1e-8) {  // rims are listed in their own boxes alone
        body_over(impl, step, true, {x, along, 5e-14, 5e-14}, body);
        for (const PlanFunction& f : body.shadow)
          near += f.kind == PlanFunction::Kind::kRim ? 1U : 0U;
      }
    }
  }
  EXPECT_EQ(near, 0U);
}

}  // namespace
}  // namespace diesink::test
