// The cutter's shape: the one thing the path planner and the verification share.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "core/part_program/part_program.h"
#include "core/result.h"

namespace diesink {

// A unit normal whose part in plan is no longer than this has no direction there but by rounding:
// the ground is level, and the cutter's disk is not shifted to a side of its contact.
inline constexpr double kLevel = 1e-12;

// A cutter that turns about the z axis above its tip: a disk of radius flat() at the tip's height,
// a corner of radius corner() around it, and a straight shank above. corner() = radius() is a ball,
// 0 a flat end, between them a bull nose. It is the body of all points at most corner() away from
// the upright column of radius flat() that begins corner() above the tip.
class CutterShape {
 public:
  // Errors: kInput where the diameter is not positive, or the corner radius negative or beyond
  //         half the diameter.
  static Result<CutterShape> make(const Cutter& cutter);

  [[nodiscard]] double radius() const { return radius_; }
  [[nodiscard]] double corner() const { return corner_; }
  [[nodiscard]] double flat() const { return flat_; }

  // Height of the cutter's lower surface above its tip at the distance rho from the axis.
  // Needs: 0 <= rho <= radius(); a rho beyond by rounding counts as radius().
  [[nodiscard]] double height(double rho) const {
    const double d = rho - flat_;
    if (d <= 0 || corner_ <= 0) return 0;
    const double below = (corner_ - d) * (corner_ + d);
    return below > 0 ? corner_ - std::sqrt(below) : corner_;
  }

 private:
  CutterShape(double radius, double corner)
      : radius_(radius), corner_(corner), flat_(radius - corner) {}
  double radius_, corner_, flat_;
};

}  // namespace diesink
