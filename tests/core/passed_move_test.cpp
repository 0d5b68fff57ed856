// How low a cutter comes over a point beside a straight move, against many of its places.
// SPDX-License-Identifier: Apache-2.0
#include "core/machining/passed_move.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

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
}  // namespace diesink
