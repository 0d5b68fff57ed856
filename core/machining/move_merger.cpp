// SPDX-License-Identifier: Apache-2.0
#include "core/machining/move_merger.h"

#include <algorithm>

namespace diesink {

void MoveMerger::add(const Vec3& tip, std::vector<SweepMove>& moves) {
  if (!begun_) {
    begun_ = true;
    from_ = tip;
    return;
  }
  if (!points_.empty()) {
    const Vec3 d = tip - from_;
    const double length2 = d.squaredNorm();
    bool straight = points_.size() < kMostPoints;
    for (std::size_t k = 0; straight && k < points_.size(); ++k) {
      const Vec3 o = points_[k] - from_;
      const double t = length2 > 0 ? std::clamp(o.dot(d) / length2, 0.0, 1.0) : 0;
      straight = (o - t * d).squaredNorm() <= tolerance2_;
    }
    if (!straight) {
      moves.push_back({from_, points_.back()});
      from_ = points_.back();
      points_.clear();
    }
  }
  points_.push_back(tip);
}

void MoveMerger::finish(std::vector<SweepMove>& moves) {
  if (!points_.empty()) moves.push_back({from_, points_.back()});
  points_.clear();
  begun_ = false;
}

}  // namespace diesink
