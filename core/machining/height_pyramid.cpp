// SPDX-License-Identifier: Apache-2.0
#include "core/machining/height_pyramid.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace diesink {

HeightPyramid::HeightPyramid(const PlanLattice& lattice, std::vector<double> heights)
    : lattice_(lattice) {
  constexpr double kNothing = -std::numeric_limits<double>::infinity();
  for (double& z : heights) {
    if (std::isnan(z)) z = kNothing;
  }
  levels_.push_back({lattice.columns, lattice.rows, std::move(heights)});
  while (levels_.back().columns > 1 || levels_.back().rows > 1) {
    const Level& fine = levels_.back();
    Level coarse{(fine.columns + 1) / 2, (fine.rows + 1) / 2, {}};
    coarse.top.assign(coarse.columns * coarse.rows, kNothing);
    for (std::size_t j = 0; j < fine.rows; ++j) {
      for (std::size_t i = 0; i < fine.columns; ++i) {
        double& top = coarse.top[j / 2 * coarse.columns + i / 2];
        top = std::max(top, fine.top[j * fine.columns + i]);
      }
    }
    levels_.push_back(std::move(coarse));
  }
}

bool HeightPyramid::clears(const CutterShape& cutter, const Vec3& tip, double slack) const {
  return clears(cutter, tip, slack, levels_.size() - 1, 0, 0);
}

bool HeightPyramid::clears(const CutterShape& cutter, const Vec3& tip, double slack,
                           std::size_t level, std::size_t i, std::size_t j) const {
  const Level& here = levels_[level];
  const std::size_t i1 = std::min(((i + 1) << level) - 1, lattice_.columns - 1);
  const std::size_t j1 = std::min(((j + 1) << level) - 1, lattice_.rows - 1);
  const double gap_x =
      std::max(0.0, std::max(lattice_.x(i << level) - tip.x(), tip.x() - lattice_.x(i1)));
  const double gap_y =
      std::max(0.0, std::max(lattice_.y(j << level) - tip.y(), tip.y() - lattice_.y(j1)));
  const double gap = std::sqrt(gap_x * gap_x + gap_y * gap_y);
  if (gap > cutter.radius()) return true;
  if (here.top[j * here.columns + i] <= tip.z() + cutter.height(gap) + slack) return true;
  if (level == 0) return false;
  const Level& fine = levels_[level - 1];
  for (std::size_t b = 2 * j; b < std::min(2 * j + 2, fine.rows); ++b) {
    for (std::size_t a = 2 * i; a < std::min(2 * i + 2, fine.columns); ++a) {
      if (!clears(cutter, tip, slack, level - 1, a, b)) return false;
    }
  }
  return true;
}

}  // namespace diesink
