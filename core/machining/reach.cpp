// SPDX-License-Identifier: Apache-2.0
#include "core/machining/reach.h"

#include <cmath>
#include <numbers>
#include <vector>

#include "core/parallel.h"

namespace diesink {

UnreachableArea unreachable_area(const CompoundSurface& surface, const OffsetSurface& offset,
                                 const PointDrop& drop, const std::array<double, 4>& domain,
                                 double tolerance, std::size_t samples, int threads) {
  const CutterShape& cutter = offset.cutter();
  const double width = domain[1] - domain[0], depth = domain[3] - domain[2];
  const double step = std::sqrt(width * depth / static_cast<double>(samples));
  const auto nx = static_cast<std::size_t>(std::fmax(1, std::round(width / step)));
  const auto ny = static_cast<std::size_t>(std::fmax(1, std::round(depth / step)));
  std::vector<UnreachableArea> rows(ny);
  parallel_blocks(ny, 4, threads, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t j = begin; j < end; ++j) {
      const double y = domain[2] + depth * (static_cast<double>(j) + 0.5) / static_cast<double>(ny);
      for (std::size_t i = 0; i < nx; ++i) {
        const double x =
            domain[0] + width * (static_cast<double>(i) + 0.5) / static_cast<double>(nx);
        const std::optional<CcDatum> cc = surface.at(x, y);
        if (!cc) continue;
        const double flat = cc->n.head<2>().norm();
        const double shift = cutter.corner() + (flat > 1e-12 ? cutter.flat() / flat : 0);
        const double tip = cc->z + cutter.corner() * (cc->n.z() - 1);
        const double at = drop.at(x + shift * cc->n.x(), y + shift * cc->n.y());
        if (at <= tip + tolerance) continue;
        // What the cutter leaves over (x, y) from here, from right above, and from around.
        double stays = drop.at(x, y) - cc->z;
        constexpr int kHeadings = 16, kRings = 6;
        for (int h = 0; h < kHeadings; ++h) {
          const double angle = 2 * std::numbers::pi * h / kHeadings;
          for (int r = 1; r <= kRings; ++r) {
            const double rho = cutter.radius() * r / kRings;
            const double tip_there = drop.at(x + rho * std::cos(angle), y + rho * std::sin(angle));
            if (tip_there == kNoContact) continue;
            stays = std::fmin(stays, tip_there + cutter.height(rho) - cc->z);
          }
        }
        if (!(stays > tolerance)) continue;
        rows[j].area += width * depth / static_cast<double>(nx * ny);
        rows[j].height = std::fmax(rows[j].height, stays);
      }
    }
  });
  UnreachableArea sum;
  for (const UnreachableArea& row : rows) {
    sum.area += row.area;
    sum.height = std::fmax(sum.height, row.height);
  }
  return sum;
}

}  // namespace diesink
