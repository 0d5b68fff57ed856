// How low a cutter comes over a point beside a straight move, against many of its places.
// SPDX-License-Identifier: Apache-2.0
#include "core/machining/passed_move.h"

#include <gtest/gtest.h>
#include <vector>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "core/machining/move_bins.h"

namespace diesink {
namespace {

// The lowest of the cutter's places along the move, by dense steps and the steps about the lowest.
double lowest_of_places(const CutterShape& cutter, double slope, double length, double u,
                        double w) {
  constexpr int kSteps = 400;
  double from = std::max(0.0, u - cutter.radius()), to = std::min(length, u + cutter.radius());
  double least = std::numeric_limits<double>::infinity();
  for (int round = 0; round < 4; ++round) {
    double at = from;
    const double step = (to - from) / kSteps;
    for (int k = 0; k <= kSteps; ++k) {
      const double s = from + k * step, rho = std::hypot(w, s - u);
      const double height = rho <= cutter.radius() ? slope * s + cutter.height(rho) : least;
      if (height < least) {
        least = height;
        at = s;
      }
    }
    from = std::max(from, at - step);
    to = std::min(to, at + step);
  }
  return least;
}

TEST(PassedMove, LowestOverAPointIsTheLowestOfAllPlaces) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> part(0, 1);
  int over = 0;
  for (int k = 0; k < 4000; ++k) {
    const double R = 3;
    const double corner = k % 5 == 0 ? R : k % 5 == 1 ? 0 : 0.05 + 2.9 * part(random);
    const CutterShape cutter = CutterShape::make({2 * R, corner}).value();
    // Up to 86 degrees, level too.
    const double slope = k % 7 == 0 ? 0 : std::tan(3 * (part(random) - 0.5));
    const double length = 0.01 + 8 * part(random), u = (length + 4) * part(random) - 2;
    const double w = R * part(random);
    const double found = lowest_over(cutter, 0, slope, length, u, w * w);
    const double places = lowest_of_places(cutter, slope, length, u, w);
    if (std::isinf(found)) {
      EXPECT_TRUE(std::isinf(places)) << k;
      continue;
    }
    ++over;
    // Never lower than the cutter comes, and no higher than the search may end.
    const double near = 1e-5 * R;
    EXPECT_LE(found, places + near) << "corner " << corner << " slope " << slope << " u " << u
                                    << " w " << w << " length " << length;
    EXPECT_GE(found, places - 1e-2 * (1 + std::fabs(slope)) * R / 400)
        << "corner " << corner << " slope " << slope << " u " << u << " w " << w;
  }
  EXPECT_GT(over, 2000);
}

}  // namespace
double distance_to(const PassedMove& move, const Vec2& p) {
  const double along = std::clamp((p - move.from).dot(move.along), 0.0, move.length);
  return (move.from + along * move.along - p).norm();
}

TEST(PassedMove, ABoxIsNoLowerThanTheMoveNearIt) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> at(-10, 10), part(0, 1);
  for (int k = 0; k < 2000; ++k) {
    const PassedMove move({at(random), at(random), at(random)},
                          {at(random), at(random), at(random)});
    const Vec2 low(at(random), at(random));
    const PlanBox box{low.x(), low.x() + part(random), low.y(), low.y() + part(random)};
    const double reach = 3 * part(random), low_near = move.low_near(box, reach);
    const double s = part(random), u = part(random) * (box.x1 - box.x0);
    const Vec2 p(box.x0 + u, box.y0 + part(random) * (box.y1 - box.y0));
    const Vec2 tip = move.from + s * move.d;
    if ((tip - p).norm() > reach) continue;
    EXPECT_GE(move.z + s * move.length * move.slope, low_near - 1e-12);
  }
}

TEST(MoveBins, TheNearestMovesAreFound) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> at(0, 100), step(-3, 3);
  std::vector<PassedMove> moves;
  for (int k = 0; k < 600; ++k) {
    const Vec3 from(at(random), at(random), at(random));
    const Vec3 to = k % 20 == 0 ? Vec3(at(random), at(random), 0)
                                : Vec3(from + Vec3(step(random), step(random), step(random)));
    moves.emplace_back(from, to);
  }
  const double near = 1.5;
  const MoveBins bins(moves, {10, 90, 5, 95}, near);
  int seen = 0;
  for (int k = 0; k < 2000; ++k) {
    const Vec2 p(at(random), at(random));
    const MoveBins::Nearest found = bins.nearest(p);
    if (p.x() < 10 || p.x() > 90 || p.y() < 5 || p.y() > 95) continue;
    std::vector<double> far;
    for (const PassedMove& move : moves) far.push_back(distance_to(move, p));
    std::sort(far.begin(), far.end());
    for (int m = 0; m < 2; ++m) {
      if (far[m] > near) continue;
      ++seen;
      ASSERT_GT(found.count, m);
      EXPECT_NEAR((found.tip[m].head<2>() - p).norm(), far[m], 1e-12);
    }
  }
  EXPECT_GT(seen, 500);
}

}  // namespace diesink
