// SPDX-License-Identifier: Apache-2.0
#include "core/machining/facet_part.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace diesink {

Vec3 FacetPart::middle() const {
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = 0; k < size; ++k) sum += p[k];
  return sum / static_cast<double>(size);
}

double FacetPart::area() const {
  double twice = 0;
  for (std::size_t k = 2; k < size; ++k) {
    const Vec3 a = p[k - 1] - p[0], b = p[k] - p[0];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return std::fabs(twice) / 2;
}

PlanBox FacetPart::box() const {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  PlanBox box{kInfinity, -kInfinity, kInfinity, -kInfinity};
  for (std::size_t k = 0; k < size; ++k) {
    box.x0 = std::min(box.x0, p[k].x());
    box.x1 = std::max(box.x1, p[k].x());
    box.y0 = std::min(box.y0, p[k].y());
    box.y1 = std::max(box.y1, p[k].y());
  }
  return box;
}

std::array<FacetPart, 2> halves(const FacetPart& part) {
  const PlanBox box = part.box();
  const int axis = box.x1 - box.x0 >= box.y1 - box.y0 ? 0 : 1;
  const double at = axis == 0 ? (box.x0 + box.x1) / 2 : (box.y0 + box.y1) / 2;
  return {cut_by(part, [&](const Vec3& p) { return at - p[axis]; }),
          cut_by(part, [&](const Vec3& p) { return p[axis] - at; })};
}

}  // namespace diesink
