// The exact signs, against whole-number arithmetic written out and against laws they must obey.
// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/planar_predicates.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <random>

#include "core/tessellate/planar_order.h"

namespace diesink {
namespace {

__extension__ typedef __int128 Wide;

int sign(Wide v) { return v > 0 ? 1 : (v < 0 ? -1 : 0); }

class PlanarPredicates : public testing::Test {
 protected:
  LatticePoint point(double reach) {
    std::uniform_real_distribution<double> unit(-reach, reach);
    return {std::nearbyint(unit(random_)), std::nearbyint(unit(random_))};
  }
  std::mt19937_64 random_{7};
};

// Small boards make many exact zeros; 2^29 is as far as 128 bits reach.
TEST_F(PlanarPredicates, AgreeWithPlainIntegers) {
  int zeros = 0;
  for (int i = 0; i < 300000; ++i) {
    const double reach = i % 3 == 0 ? 3 : (i % 3 == 1 ? 40 : 0x1p29);
    const LatticePoint a = point(reach), b = point(reach), c = point(reach), d = point(reach);
    const auto sub = [](double p, double q) { return static_cast<Wide>(p) - static_cast<Wide>(q); };
    const Wide ax = sub(a.x, d.x), ay = sub(a.y, d.y), bx = sub(b.x, d.x), by = sub(b.y, d.y),
               cx = sub(c.x, d.x), cy = sub(c.y, d.y);
    const int turn = sign((ax - cx) * (by - cy) - (ay - cy) * (bx - cx));
    const int circle =
        sign((ax * ax + ay * ay) * (bx * cy - cx * by) + (bx * bx + by * by) * (cx * ay - ax * cy) +
             (cx * cx + cy * cy) * (ax * by - bx * ay));
    ASSERT_EQ(orientation(a, b, c), turn);
    ASSERT_EQ(exact_orientation(a, b, c), turn);
    ASSERT_EQ(in_circle(a, b, c, d), circle);
    ASSERT_EQ(exact_in_circle(a, b, c, d), circle);
    zeros += circle == 0 ? 1 : 0;
  }
  EXPECT_GT(zeros, 10000);
}

// Over the whole lattice: points in one line and on one circle by construction, and one step off.
TEST_F(PlanarPredicates, DegenerateOverTheWholeLattice) {
  std::uniform_int_distribution<std::int64_t> draw(-(std::int64_t{1} << 24), std::int64_t{1} << 24);
  const auto at = [](std::int64_t x, std::int64_t y) {
    return LatticePoint{static_cast<double>(x), static_cast<double>(y)};
  };
  for (int i = 0; i < 50000; ++i) {
    const std::int64_t u = draw(random_), v = draw(random_);
    const std::int64_t k = draw(random_), m = draw(random_);
    if (u == 0 || v == 0 || k == m) continue;
    // k (u, v) and m (u, v) are in line with 0; one step to the left of the way out is left.
    const LatticePoint zero = at(0, 0), p = at(k * u, k * v), q = at(m * u, m * v);
    ASSERT_EQ(orientation(zero, p, q), 0);
    if (k != 0) {
      const std::int64_t left = (k > 0) == (u > 0) ? 1 : -1;
      ASSERT_EQ(orientation(zero, p, at(m * u, m * v + left)), 1);
      ASSERT_EQ(orientation(zero, p, at(m * u, m * v - left)), -1);
    }
    // Mirror images of one point lie on a circle about 0, and so does it turned by 90 degrees.
    const std::int64_t x = (k * u) / 2, y = (m * v) / 2;
    if (x == 0 || y == 0 || x == y || x == -y) continue;
    std::array<LatticePoint, 3> t{at(x, y), at(-x, y), at(-x, -y)};
    if (orientation(t[0], t[1], t[2]) < 0) std::swap(t[0], t[1]);
    for (const LatticePoint& on : {at(x, -y), at(-y, x), at(y, -x), at(y, x)}) {
      ASSERT_EQ(in_circle(t[0], t[1], t[2], on), 0);
      const double outwards = on.x > 0 ? 1 : -1;
      ASSERT_EQ(in_circle(t[0], t[1], t[2], {on.x + outwards, on.y}), -1);
      ASSERT_EQ(in_circle(t[0], t[1], t[2], {on.x - outwards, on.y}), 1);
      ASSERT_EQ(in_circle(t[1], t[2], t[0], {on.x - outwards, on.y}), 1);
      ASSERT_EQ(in_circle(t[1], t[0], t[2], {on.x - outwards, on.y}), -1);
    }
  }
}

TEST_F(PlanarPredicates, LargestCoordinates) {
  constexpr double kEnd = 0x1p52;
  const LatticePoint a{-kEnd, -kEnd}, b{kEnd, -kEnd}, c{kEnd, kEnd}, d{-kEnd, kEnd};
  EXPECT_EQ(orientation(a, b, c), 1);
  EXPECT_EQ(orientation(a, c, {0, 0}), 0);
  EXPECT_EQ(orientation(a, c, {0, 1}), 1);
  EXPECT_EQ(in_circle(a, b, c, d), 0);
  EXPECT_EQ(in_circle(a, b, c, {-kEnd + 1, kEnd}), 1);
  EXPECT_EQ(in_circle(a, b, {kEnd, kEnd - 1}, d), -1);
}

// The order is a permutation, and neighbours in its last round are neighbours in the plane.
TEST_F(PlanarPredicates, InsertionOrder) {
  for (const std::size_t side : {1U, 3U, 30U, 128U}) {
    std::vector<LatticePoint> points;
    for (std::size_t i = 0; i < side * side; ++i) {
      points.push_back({static_cast<double>(i % side) * 0x1p20,
                        static_cast<double>(i / side) * 0x1p20 - 0x1p30});
    }
    const std::vector<std::uint32_t> order = insertion_order(points);
    std::vector<bool> seen(points.size(), false);
    for (const std::uint32_t i : order) {
      ASSERT_LT(i, points.size());
      ASSERT_FALSE(seen[i]);
      seen[i] = true;
    }
    ASSERT_EQ(order.size(), points.size());
    double way = 0;
    for (std::size_t k = points.size() / 4; k + 1 < order.size(); ++k) {
      const LatticePoint &p = points[order[k]], &q = points[order[k + 1]];
      way += std::hypot(p.x - q.x, p.y - q.y) * 0x1p-20;
    }
    EXPECT_LE(way, 1.5 * static_cast<double>(points.size()));
  }
}

}  // namespace
}  // namespace diesink
