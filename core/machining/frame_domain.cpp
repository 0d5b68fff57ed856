// SPDX-License-Identifier: Apache-2.0
#include "core/machining/frame_domain.h"

namespace diesink {

Span FrameDomain::pass(double y) const {
  Span span;
  for (std::size_t k = 0; k < 4; ++k) {
    const Vec2 &p = corners_[k], &q = corners_[(k + 1) % 4];
    if (y < std::fmin(p.y(), q.y()) || y > std::fmax(p.y(), q.y())) continue;
    const auto add = [&](double x) {
      span.x0 = std::fmin(span.x0, x);
      span.x1 = std::fmax(span.x1, x);
    };
    if (p.y() == q.y()) {
      add(p.x());
      add(q.x());
    } else {
      add(p.x() + (y - p.y()) / (q.y() - p.y()) * (q.x() - p.x()));
    }
  }
  return span;
}

}  // namespace diesink
