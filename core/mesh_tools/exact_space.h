// Exact signs in space for any doubles. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "core/vec.h"

namespace diesink {

// The same sign by expansions alone: slow, for what the filter below leaves open.
int exact_side(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

// The sign of the determinant of a - d, b - d, c - d: on which side of the plane through a, b and c
// the point d lies, 0 in it. Exact.
// Needs: coordinates that are 0 or of a magnitude between 2^-200 and 2^200.
// Source: Shewchuk, Adaptive precision floating-point arithmetic, 1997.
inline int side(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const double ax = a.x() - d.x(), ay = a.y() - d.y(), az = a.z() - d.z();
  const double bx = b.x() - d.x(), by = b.y() - d.y(), bz = b.z() - d.z();
  const double cx = c.x() - d.x(), cy = c.y() - d.y(), cz = c.z() - d.z();
  const double bycz = by * cz, bzcy = bz * cy, bzcx = bz * cx, bxcz = bx * cz, bxcy = bx * cy,
               bycx = by * cx;
  const double det = ax * (bycz - bzcy) + ay * (bzcx - bxcz) + az * (bxcy - bycx);
  const double sum = std::fabs(ax) * (std::fabs(bycz) + std::fabs(bzcy)) +
                     std::fabs(ay) * (std::fabs(bzcx) + std::fabs(bxcz)) +
                     std::fabs(az) * (std::fabs(bxcy) + std::fabs(bycx));
  // Shewchuk's bound is 7 * 2^-53 of the sum, and a little.
  const double bound = 0x1p-49 * sum;
  if (det > bound) return 1;
  if (det < -bound) return -1;
  if (sum == 0) return 0;  // every product has a factor that is 0 exactly
  return exact_side(a, b, c, d);
}

}  // namespace diesink
