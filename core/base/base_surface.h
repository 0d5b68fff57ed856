// What the evaluator and the tessellator ask of a base surface B.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>

namespace diesink {

// Height and slope of a base surface over one plan point: z, dz/dx, dz/dy, and the face under it
// (0 for plane and Ferguson, the triangle's index for a scan).
struct BaseHit {
  double z = 0;
  double zx = 0;
  double zy = 0;
  std::uint32_t face = 0;
};

struct PlanBox {
  double x0 = 0, x1 = 0, y0 = 0, y1 = 0;
};

struct Range {
  double lo = -std::numeric_limits<double>::infinity();
  double hi = std::numeric_limits<double>::infinity();
};

enum class Coverage : std::uint8_t { kOutside, kPartly, kInside };

// Enclosures over a plan box: certain, not sampled. Where coverage is kOutside the ranges mean
// nothing; where it is kPartly they hold wherever the surface is defined inside the box. Bound:
// every value the surface takes in the box, rounding included, lies in its range.
struct BaseBounds {
  Coverage coverage = Coverage::kPartly;
  Range z;
  Range zx, zy;         // first derivatives in plan
  Range zxx, zxy, zyy;  // second derivatives in plan; unbounded where not known
};

}  // namespace diesink
