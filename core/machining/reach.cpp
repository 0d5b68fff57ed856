// SPDX-License-Identifier: Apache-2.0
#include "core/machining/reach.h"

#include <algorithm>
#include <cmath>
#include <limits>
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
  constexpr std::size_t kHeadings = 16;
  constexpr std::size_t kRings = 6;
  std::array<Vec2, kHeadings> headings;
  for (std::size_t h = 0; h < kHeadings; ++h) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(h) / kHeadings;
    headings[h] = Vec2(std::cos(angle), std::sin(angle));
  }
  // The samples, which also tell at once where the part keeps the cutter from lower places.
  std::vector<std::optional<CcDatum>> samples_at(nx * ny);
  std::vector<double> tops(nx * ny, kNoContact);
  const auto sample_x = [&](std::size_t i) {
    return domain[0] + width * (static_cast<double>(i) + 0.5) / static_cast<double>(nx);
  };
  const auto sample_y = [&](std::size_t j) {
    return domain[2] + depth * (static_cast<double>(j) + 0.5) / static_cast<double>(ny);
  };
  parallel_blocks(ny, 4, threads, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t j = begin; j < end; ++j) {
      for (std::size_t i = 0; i < nx; ++i) {
        const auto& cc = samples_at[j * nx + i] = surface.at(sample_x(i), sample_y(j));
        if (cc) tops[j * nx + i] = cc->z;
      }
    }
  });
  const double per_x = static_cast<double>(nx) / width, per_y = static_cast<double>(ny) / depth;
  // Whether a sample keeps a tip at (x, y) from coming under `least`.
  const auto kept_above = [&](double x, double y, double least) {
    const double i = (x - domain[0]) * per_x, j = (y - domain[2]) * per_y;
    if (!(i >= 0 && j >= 0 && i < static_cast<double>(nx) && j < static_cast<double>(ny))) {
      return false;
    }
    const std::size_t a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
    // The mesh under the drop may lie a little lower.
    const double high = tops[b * nx + a] - tolerance - least;
    if (!(high >= 0)) return false;
    const double ox = sample_x(a) - x, oy = sample_y(b) - y, rho2 = ox * ox + oy * oy;
    return rho2 <= cutter.radius() * cutter.radius() && high >= cutter.height(std::sqrt(rho2));
  };
  std::array<double, kRings + 1> lifts;
  for (std::size_t r = 1; r <= kRings; ++r)
    lifts[r] = cutter.height(cutter.radius() * static_cast<double>(r) / kRings);
  std::vector<UnreachableArea> rows(ny);
  parallel_blocks(ny, 4, threads, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t j = begin; j < end; ++j) {
      const double y = sample_y(j);
      for (std::size_t i = 0; i < nx; ++i) {
        const double x = sample_x(i);
        const std::optional<CcDatum>& cc = samples_at[j * nx + i];
        if (!cc) continue;
        const double flat = cc->n.head<2>().norm();
        const double shift = cutter.corner() + (flat > kLevel ? cutter.flat() / flat : 0);
        const double tip = cc->z + cutter.corner() * (cc->n.z() - 1);
        const double allowed = tip + tolerance;
        const double at = drop.at(x + shift * cc->n.x(), y + shift * cc->n.y(),
                                  std::nextafter(allowed, std::numeric_limits<double>::infinity()));
        if (at <= allowed) continue;
        // What the cutter leaves over (x, y) from here, from right above, and from around.
        double stays = drop.at(x, y) - cc->z;
        for (std::size_t h = 0; h < kHeadings; ++h) {
          for (std::size_t r = 1; r <= kRings && stays > tolerance; ++r) {
            const double rho = cutter.radius() * static_cast<double>(r) / kRings;
            const double lift = lifts[r] - cc->z;
            const Vec2 there = Vec2(x, y) + rho * headings[h];
            if (kept_above(there.x(), there.y(), stays - lift)) continue;
            const double tip_there = drop.at(there.x(), there.y(), stays - lift);
            if (tip_there == kNoContact) continue;
            stays = std::min(stays, tip_there + lift);
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
