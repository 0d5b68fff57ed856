// What the files of the Ferguson surface share among themselves.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#include "core/base/ferguson.h"

namespace diesink {

namespace scalar {

struct Lift {
  double operator()(double v) const { return v; }
};
#define DIESINK_INLINE inline
#include "core/base/ferguson_formulas-inl.h"
#undef DIESINK_INLINE

}  // namespace scalar

// Parameters as far out as this are those of a failed iteration.
inline constexpr double kFarOutside = 8;

// The span of a parameter among `count` points; the borders belong to the first and last span.
inline int span_of(double u, int count) { return std::clamp(static_cast<int>(u), 0, count - 2); }

// Far enough from the patch's border that no other patch can claim the point.
inline bool well_inside(const FergusonPatch& patch, double s, double t) {
  const double margin = 1e-6 + 4 * patch.closeness;
  return s > margin && s < 1 - margin && t > margin && t < 1 - margin;
}

// A short list of parameter boxes that never allocates; what does not fit grows the last one.
class ParameterBoxes {
 public:
  void add(const ParameterBox& box) {
    if (count_ < items_.size()) {
      items_[count_++] = box;
      return;
    }
    ParameterBox& last = items_.back();
    last = {std::min(last.s0, box.s0), std::max(last.s1, box.s1), std::min(last.t0, box.t0),
            std::max(last.t1, box.t1)};
  }
  [[nodiscard]] std::span<const ParameterBox> items() const { return {items_.data(), count_}; }

 private:
  std::array<ParameterBox, 64> items_;
  std::size_t count_ = 0;
};

// Adds boxes that together contain every parameter of the patch, its border widened by closeness,
// whose plan point lies in `box`. Certain, rounding included.
void preimage(const FergusonPatch& patch, const PlanBox& box, ParameterBoxes& out);

// Shrinks the box to what the plan map can bring into `plan`. True where that fell strictly inside
// the box: then every point of `plan` has exactly one foot in it.
bool contract_inside(const FergusonPatch& patch, const PlanBox& plan, ParameterBox& box);

// Whether the patch's plan Jacobian is shown to be positive (negative if `turned`) everywhere on
// it.
bool unfolded(const FergusonPatch& patch, bool turned);

// A point near which two sides of a closed polygon cross; empty where none do.
std::optional<Vec2> outline_crossing(std::span<const Vec2> outline);

// The polynomial from which the patch's inversion starts.
InversePatch fit_inverse(const FergusonPatch& patch);

}  // namespace diesink
