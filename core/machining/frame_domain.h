// The domain of a path in the frame of its passes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>

#include "core/machining/offset_surface.h"

namespace diesink {

// The domain in the turned frame: where a pass at y begins and ends.
class FrameDomain {
 public:
  FrameDomain(const OffsetSurface& offset, const std::array<double, 4>& d) {
    const std::array<Vec3, 4> corners{Vec3(d[0], d[2], 0), Vec3(d[1], d[2], 0), Vec3(d[1], d[3], 0),
                                      Vec3(d[0], d[3], 0)};
    for (std::size_t k = 0; k < 4; ++k) corners_[k] = offset.to_frame(corners[k]).head<2>();
    low_ = high_ = corners_[0].y();
    for (const Vec2& c : corners_) {
      low_ = std::fmin(low_, c.y());
      high_ = std::fmax(high_, c.y());
    }
    // Turned, the outermost passes meet the domain at corners only: a hair inside they have a
    // length.
    if (!(pass(low_).x1 > pass(low_).x0)) {
      const double hair = std::fmin(1e-3 * offset.cutter().radius(), (high_ - low_) / 8);
      low_ += hair;
      high_ -= hair;
    }
    // Passes begin at the side of the program's own first corner.
    from_high_ = corners_[0].y() - low_ > high_ - corners_[0].y();
  }
  [[nodiscard]] double low() const { return low_; }
  [[nodiscard]] double high() const { return high_; }
  [[nodiscard]] bool from_high() const { return from_high_; }
  // Anticlockwise.
  [[nodiscard]] const std::array<Vec2, 4>& corners() const { return corners_; }
  // Where the pass at y runs; empty where it misses the domain.
  [[nodiscard]] Span pass(double y) const;

 private:
  std::array<Vec2, 4> corners_;
  double low_ = 0, high_ = 0;
  bool from_high_ = false;
};

}  // namespace diesink
