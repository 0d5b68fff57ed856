// Exact signs in plan against whole numbers.
// SPDX-License-Identifier: Apache-2.0
#include "core/base/exact_plan.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

namespace diesink {
namespace {

TEST(ExactTurn, AgreesWithWholeNumbers) {
  // Points of a lattice with 2^26 steps a side, near one line: products fit whole numbers.
  std::mt19937_64 random(7);
  std::uniform_int_distribution<std::int64_t> step(-(1 << 26), 1 << 26), little(-1, 1);
  int zeros = 0;
  for (int i = 0; i < 200000; ++i) {
    const std::int64_t ax = step(random), ay = step(random), bx = step(random), by = step(random);
    const std::int64_t k = step(random) % 64;
    const std::int64_t cx = ax + (bx - ax) / 64 * k + little(random),
                       cy = ay + (by - ay) / 64 * k + little(random);
    const std::int64_t det = (ax - cx) * (by - cy) - (ay - cy) * (bx - cx);
    const int sign = det > 0 ? 1 : det < 0 ? -1 : 0;
    zeros += sign == 0 ? 1 : 0;
    const auto d = [](std::int64_t v) { return static_cast<double>(v); };
    ASSERT_EQ(turn(d(ax), d(ay), d(bx), d(by), d(cx), d(cy)), sign);
    ASSERT_EQ(exact_turn(d(ax), d(ay), d(bx), d(by), d(cx), d(cy)), sign);
  }
  EXPECT_GT(zeros, 0);
  // Differences that no double holds: a and b far away on either side, c near where their line
  // passes the origin, all in steps of 1/64.
  std::uniform_int_distribution<std::int64_t> far(-(std::int64_t{1} << 52), std::int64_t{1} << 52);
  std::uniform_int_distribution<std::int64_t> near(-2, 2);
  zeros = 0;
  for (int i = 0; i < 200000; ++i) {
    const std::int64_t ax = 64 * far(random), ay = 64 * far(random),
                       bx = -ax + 64 * near(random) * (i % 2),
                       by = -ay + 64 * near(random) * (i % 2);
    const std::int64_t cx = near(random), cy = near(random) * (i % 3);
    __extension__ using Wide = __int128;
    const auto wide = [](std::int64_t v) { return static_cast<Wide>(v); };
    const Wide det = (wide(ax) - cx) * (wide(by) - cy) - (wide(ay) - cy) * (wide(bx) - cx);
    const int sign = det > 0 ? 1 : det < 0 ? -1 : 0;
    zeros += sign == 0 ? 1 : 0;
    const auto d = [](std::int64_t v) { return static_cast<double>(v) / 64; };
    ASSERT_EQ(turn(d(ax), d(ay), d(bx), d(by), d(cx), d(cy)), sign);
  }
  EXPECT_GT(zeros, 0);
  // One last digit beside the diagonal, far beyond what rounded products tell.
  const double up = std::nextafter(0.5, 1);
  EXPECT_EQ(turn(0.5, 0.5, 12, 12, 24, 24), 0);
  EXPECT_EQ(turn(0.5, up, 12, 12, 24, 24), 1);
  EXPECT_EQ(turn(up, 0.5, 12, 12, 24, 24), -1);
}

// All ways from a point of the lattice round it, once and on a grid of ulps far from the origin,
// where angles cannot be told apart by rounded ones: sorted by products of whole numbers.
TEST(ClockwiseBefore, OrdersAllWaysRoundAPoint) {
  const auto turn_of = [](int ax, int ay, int bx, int by) { return ax * by - ay * bx; };
  // Clockwise from (1, 0): below first, then behind, then above, ahead last.
  const auto quarter = [](int x, int y) { return y < 0 ? 0 : y > 0 ? 2 : x < 0 ? 1 : 3; };
  for (const auto& [at, unit] : {std::pair{0.0, 1.0}, {1e6, 0x1p-33}}) {
    const PlanPoint o{at, -at}, from{at + 3 * unit, -at};
    for (int px = -3; px <= 3; ++px) {
      for (int py = -3; py <= 3; ++py) {
        for (int qx = -3; qx <= 3; ++qx) {
          for (int qy = -3; qy <= 3; ++qy) {
            if ((px == 0 && py == 0) || (qx == 0 && qy == 0)) continue;
            const int kp = quarter(px, py), kq = quarter(qx, qy);
            const bool before = kp != kq ? kp < kq : turn_of(px, py, qx, qy) < 0;
            EXPECT_EQ(clockwise_before(o, from, {at + px * unit, -at + py * unit},
                                       {at + qx * unit, -at + qy * unit}),
                      before)
                << px << ',' << py << ' ' << qx << ',' << qy << " at " << at;
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace diesink
