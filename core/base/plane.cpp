// SPDX-License-Identifier: Apache-2.0
#include "core/base/plane.h"

#include <cstddef>

#include "core/interval.h"

namespace diesink {

PlaneSurface::PlaneSurface(const PlaneBase& plane)
    : x0_(plane.point.x()),
      y0_(plane.point.y()),
      z0_(plane.point.z()),
      // + 0.0 turns the -0 of a level plane into 0.
      zx_(-plane.normal.x() / plane.normal.z() + 0.0),
      zy_(-plane.normal.y() / plane.normal.z() + 0.0) {}

bool PlaneSurface::at(double x, double y, BaseHit& hit) const {
  hit.z = zx_ * (x - x0_) + (z0_ + zy_ * (y - y0_));
  hit.zx = zx_;
  hit.zy = zy_;
  hit.face = 0;
  return true;
}

void PlaneSurface::row(double y, std::span<const double> xs, double* z) const {
  const double along = z0_ + zy_ * (y - y0_);
  for (std::size_t i = 0; i < xs.size(); ++i) z[i] = zx_ * (xs[i] - x0_) + along;
}

BaseBounds PlaneSurface::bounds(const PlanBox& box) const {
  BaseBounds out;
  out.coverage = Coverage::kInside;
  const Range dx = Range{box.x0, box.x1} - point_range(x0_);
  const Range dy = Range{box.y0, box.y1} - point_range(y0_);
  out.z = zx_ * dx + (point_range(z0_) + zy_ * dy);
  out.zx = point_range(zx_);
  out.zy = point_range(zy_);
  out.zxx = out.zxy = out.zyy = point_range(0);
  return out;
}

}  // namespace diesink
