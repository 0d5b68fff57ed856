// Parts far from the origin are tessellated near it: of their coordinates, digits are left below
// what surfaces differ by only there.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "core/compound/compound_surface.h"

namespace diesink {

// Altitude below which a triangle of the finished mesh has no area, in mm: 1e-12 of the size, or,
// far from the origin, what the coordinates there leave of that.
double least_altitude(const CompoundSurface& surface);

// A surface and the way from its place in the program to where it is computed: to the origin where
// its domain is many times as far from it as it is wide. (Scans stay: what counts as one point
// among their triangles follows from their file.)
class Home {
 public:
  // Needs: the surface given outlives it.
  explicit Home(const CompoundSurface& given);

  [[nodiscard]] const CompoundSurface& surface() const { return moved_ ? *moved_ : given_; }
  [[nodiscard]] bool is_moved() const { return moved_.has_value(); }
  // From a place of the program to the same one of surface(). Exact for the domain's sides and
  // whatever else is a multiple of their ulp.
  [[nodiscard]] const Vec2& way() const { return way_; }
  [[nodiscard]] PlanBox there(const PlanBox& box) const {
    return {box.x0 + way_.x(), box.x1 + way_.x(), box.y0 + way_.y(), box.y1 + way_.y()};
  }

 private:
  const CompoundSurface& given_;
  std::optional<CompoundSurface> moved_;
  Vec2 way_ = Vec2::Zero();
};

}  // namespace diesink
