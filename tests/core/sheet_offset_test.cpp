// How far triangles that stand for a scan are off it.
// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/sheet_offset.h"

#include <gtest/gtest.h>

namespace diesink::test {
namespace {

// Over a ridge, a triangle with its corners on either side and one beyond the end of the scan.
TEST(SheetOffset, IsThatOfTheFarthestPoint) {
  TriangleMesh roof;
  roof.positions = {{0, 0, 0}, {10, 0, 2}, {20, 0, 0}, {0, 30, 0}, {10, 30, 2}, {20, 30, 0}};
  roof.triangles = {{0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}};
  const Result<ScannedSurface> scan = ScannedSurface::make(roof, {});
  ASSERT_TRUE(scan);
  const SheetOffset piece = sheet_offset(*scan, {Vec3(1, 1, 0.2), {9, 1, 1.8}, {5, 20, 1}});
  EXPECT_NEAR(piece.height, 0, 1e-14);
  EXPECT_EQ(piece.beyond, 0);
  // The ridge passes 1.6 above it where it leaves it.
  const SheetOffset through = sheet_offset(*scan, {Vec3(2, 5, 0.4), {18, 5, 0.4}, {10, 25, 2}});
  EXPECT_NEAR(through.height, 1.6, 1e-12);
  EXPECT_EQ(through.beyond, 0);
  const SheetOffset over_end = sheet_offset(*scan, {Vec3(2, 29, 0.4), {8, 29, 1.6}, {5, 32, 1}});
  EXPECT_NEAR(over_end.height, 0, 1e-14);
  EXPECT_NEAR(over_end.beyond, 4, 1e-12);
}

// What lies beyond an edge, or over it by rounding alone, is as far off as it likes.
TEST(SheetOffset, ASideAlongAWallIsNotOffByTheWall) {
  TriangleMesh step;
  step.positions = {{0, 0, 0}, {10, 0, 0}, {0, 10, 0}, {10, 0, 5}, {10, 10, 5}, {0, 10, 5}};
  step.triangles = {{0, 1, 2}, {3, 4, 5}};
  const Result<ScannedSurface> scan = ScannedSurface::make(step, {});
  ASSERT_TRUE(scan);
  const SheetOffset beside =
      sheet_offset(*scan, {Vec3(0, 0, 0), {10 + 1e-13, 1e-13, 0}, {1e-13, 10, 0}});
  EXPECT_NEAR(beside.height, 0, 1e-12);
  EXPECT_EQ(beside.beyond, 0);
  const SheetOffset over = sheet_offset(*scan, {Vec3(0, 0, 0), {10, 0.1, 0}, {0, 10, 0}});
  EXPECT_NEAR(over.height, 5, 1e-12);
}

}  // namespace
}  // namespace diesink::test
