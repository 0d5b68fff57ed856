// Triangles cut to boxes of the plan.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

#include "core/vec.h"

namespace diesink {

struct PlanPolygon {
  std::array<Vec3, 9> p;
  std::size_t size = 0;
  void add(const Vec3& v) { p[size++] = v; }
};

// The part of a convex polygon where sign * (coordinate - at) >= 0.
// Needs: room for one more point; a triangle may be cut four times.
inline PlanPolygon cut(const PlanPolygon& in, int axis, double at, double sign) {
  PlanPolygon out;
  for (std::size_t k = 0; k < in.size; ++k) {
    const Vec3 &a = in.p[k], &b = in.p[(k + 1) % in.size];
    const double da = sign * (a[axis] - at), db = sign * (b[axis] - at);
    if (da >= 0) out.add(a);
    if ((da > 0 && db < 0) || (da < 0 && db > 0)) {
      Vec3 c = a + da / (da - db) * (b - a);
      c[axis] = at;
      out.add(c);
    }
  }
  return out;
}

}  // namespace diesink
