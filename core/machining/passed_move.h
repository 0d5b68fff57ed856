// A straight move of a cutter as points beside it see it: how low the cutter comes over them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/base_surface.h"
#include "core/machining/cutter.h"
#include "core/vec.h"

namespace diesink {

// The lowest height of a cutter over a point beside a straight move that begins at the height z and
// rises by `slope` along its `length` in plan: the point lies u along the move and w across it,
// w2 = w². Infinity where the cutter does not come over it.
// Units: mm.
// Bound: an upper one, exact for balls and flat ends; for bull noses within 1e-5 of the radius on
//        slopes up to 14 (86 degrees).
double lowest_over(const CutterShape& cutter, double z, double slope, double length, double u,
                   double w2);

struct PassedMove {
  PassedMove(const Vec3& begin, const Vec3& end);

  // Where points within `reach` of the strip y0 .. y1 may lie in x, less the reach itself.
  [[nodiscard]] std::array<double, 2> over(double low_y, double high_y) const;

  // No point of the box is nearer in plan.
  [[nodiscard]] double gap(const PlanBox& box) const;

  // The tip is no lower where it is within `reach` of the box in plan.
  [[nodiscard]] double low_near(const PlanBox& box, double reach) const {
    const double u = ((box.x0 + box.x1) / 2 - from.x()) * along.x() +
                     ((box.y0 + box.y1) / 2 - from.y()) * along.y();
    const double half =
        reach +
        (std::fabs(along.x()) * (box.x1 - box.x0) + std::fabs(along.y()) * (box.y1 - box.y0)) / 2;
    return z + slope * std::clamp(slope > 0 ? u - half : u + half, 0.0, length);
  }

  // Lowers what is left over p to where the cutter comes. (Here, as most points are passed over.)
  void lower(const CutterShape& cutter, const Vec2& p, double& left) const {
    if (low >= left) return;
    const double R = cutter.radius();
    const double ox = p.x() - from.x(), oy = p.y() - from.y();
    const double u = ox * along.x() + oy * along.y(), w = oy * along.x() - ox * along.y();
    const double off = u - std::clamp(u, 0.0, length), near2 = w * w + off * off;
    if (near2 > R * R || low + cutter.height(std::sqrt(near2)) >= left) return;
    left = std::min(left, lowest_over(cutter, z, slope, length, u, w * w));
  }

  Vec2 from, d, along{1, 0};
  double length = 0, low = 0, slope = 0, z = 0, y0 = 0, y1 = 0;
};

}  // namespace diesink
