// SPDX-License-Identifier: Apache-2.0
#include "core/machining/cutter.h"

#include "core/number.h"

namespace diesink {

Result<CutterShape> CutterShape::make(const Cutter& cutter) {
  const double radius = cutter.diameter / 2;
  constexpr double kLargestDiameter = 1e9;  // as lengths in part programs
  if (!(cutter.diameter > 0 && cutter.diameter <= kLargestDiameter)) {
    return Error{ErrorCode::kInput,
                 "a cutter's diameter must be positive and at most 1e9 (got " +
                     number_text(cutter.diameter) + ")",
                 {}};
  }
  if (!(cutter.corner_radius >= 0) || cutter.corner_radius > radius * (1 + 1e-9)) {
    return Error{ErrorCode::kInput,
                 "a cutter's corner radius must lie between 0 and half its diameter " +
                     number_text(radius) + " (got " + number_text(cutter.corner_radius) + ")",
                 {}};
  }
  return CutterShape(radius, std::fmin(cutter.corner_radius, radius));
}

}  // namespace diesink
