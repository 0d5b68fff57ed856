// Which straight moves of a tip pass near a place in plan.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/machining/passed_move.h"

namespace diesink {

class MoveBins {
 public:
  // Of the parts of the moves in `box`. Needs: near > 0; `moves` outlive it.
  MoveBins(std::span<const PassedMove> moves, const PlanBox& box, double near);

  // Where the two moves nearest to p in plan come nearest to it, the nearest first, among those
  // that pass within `near`; some that pass a little further off are seen as well.
  struct Nearest {
    int count = 0;
    Vec3 tip[2];
  };
  [[nodiscard]] Nearest nearest(const Vec2& p) const;

 private:
  template <class Do>
  void each_bin(const PassedMove& move, const Do& act) const;

  std::span<const PassedMove> moves_;
  double near_, x0_ = 0, y0_ = 0, per_ = 0;  // bins to a unit of length
  std::size_t columns_ = 0, rows_ = 0;
  std::vector<std::uint32_t> begin_, items_;  // of each bin, and the end
};

}  // namespace diesink
