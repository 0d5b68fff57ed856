// Tool paths for random part programs, simulated: no gouge, no rapid move through the part.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "core/machining/tool_path_plan.h"
#include "core/machining/verify.h"
#include "core/machining/wide_surface.h"
#include "core/part_program/part_program.h"
#include "core/tessellate/tessellate.h"
#include "tests/support/random_program.h"

namespace diesink {
namespace {

void plan_and_verify(std::uint64_t seed, test::RandomBase base, PathMethod method) {
  test::RandomProgramOptions random;
  random.size = 60;
  random.solids = 5;
  random.base = base;
  Diagnostics diagnostics;
  const auto program =
      parse_part_program(test::random_part_program(seed, random), "random.part", diagnostics);
  ASSERT_TRUE(program.has_value());
  const Result<CompoundSurface> surface = CompoundSurface::make(*program);
  ASSERT_TRUE(surface);
  PathOptions options;
  constexpr Cutter kCutters[] = {{6, 3}, {8, 1}, {5, 0}};
  options.cutter = kCutters[seed % 3];
  options.method = method;
  options.cusp = 0.2;
  options.threads = 2;
  options.angle = seed % 2 == 0 ? 0 : 0.7;
  options.pattern = seed % 4 < 2 ? PathPattern::kZigzag : PathPattern::kOneway;
  options.intol = options.outtol = 0.05;
  const Result<PlannedPath> planned = plan_path(*surface, options);
  ASSERT_TRUE(planned) << planned.error().message;
  EXPECT_LE(planned->report.overcut_bound, options.intol * (1 + 1e-9));

  const Result<CompoundSurface> wide = widened(*surface, options.cutter.diameter / 2);
  TessellationOptions how;
  how.tolerance = 0.004;
  const Result<Tessellation> mesh = tessellate(*wide, how);
  ASSERT_TRUE(mesh);
  VerifyOptions check;
  check.cutter = options.cutter;
  check.intol = check.outtol = 0.05;
  check.cusp = options.cusp;
  check.spacing = 0.25;
  check.threads = 2;
  const Result<VerifyReport> found =
      verify_path(*surface, mesh->mesh, mesh->report.certified_deviation, planned->path, check);
  ASSERT_TRUE(found);
  EXPECT_LE(found->max_gouge - found->bound, options.intol + 1e-9)
      << "gouge, seed " << seed << " at " << found->max_gouge_at.transpose();
  EXPECT_EQ(found->rapid_plunges, 0u);
  if (method == PathMethod::kDrop) {
    // Pockets hardly wider than the cutter may be missed between passes; not more.
    EXPECT_LE(found->uncut_area, 1e-3 * 60 * 60)
        << "excess, seed " << seed << " at " << found->max_excess_at.transpose();
  }
}

TEST(RandomParts, DroppedPathsNeitherGougeNorPlungeOnAPlane) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    plan_and_verify(seed, test::RandomBase::kPlane, PathMethod::kDrop);
  }
}

TEST(RandomParts, NorOnAFergusonSurface) {
  for (std::uint64_t seed = 12; seed <= 13; ++seed) {
    plan_and_verify(seed, test::RandomBase::kFerguson, PathMethod::kDrop);
  }
}

TEST(RandomParts, NorWithHolesAllRound) {
  for (std::uint64_t seed = 22; seed <= 22; ++seed) {
    plan_and_verify(seed, test::RandomBase::kNone, PathMethod::kDrop);
  }
}

TEST(RandomParts, NeitherDoPathsOfContacts) {
  plan_and_verify(31, test::RandomBase::kPlane, PathMethod::kCc);
  plan_and_verify(33, test::RandomBase::kFerguson, PathMethod::kCc);
}

}  // namespace
}  // namespace diesink
