// The plane as a base surface.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "core/base/base_surface.h"
#include "core/part_program/part_program.h"

namespace diesink {

class PlaneSurface {
 public:
  // Needs: a normal with z > 0.
  explicit PlaneSurface(const PlaneBase& plane);

  // Always true: a plane has no border.
  bool at(double x, double y, BaseHit& hit) const;

  // Heights at (xs[i], y): the same digits as at(). Shape: z has the length of xs.
  void row(double y, std::span<const double> xs, double* z) const;

  [[nodiscard]] BaseBounds bounds(const PlanBox& box) const;

  [[nodiscard]] double zx() const { return zx_; }
  [[nodiscard]] double zy() const { return zy_; }

 private:
  double x0_, y0_, z0_, zx_, zy_;
};

}  // namespace diesink
