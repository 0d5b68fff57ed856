// What of many boxes of the plan lies in a box.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/base_surface.h"

namespace diesink {

// Boxes of the plan by the cells of a uniform grid, about as many as there are boxes: what reaches
// into a box is found without asking them all.
// Needs: the boxes outlive it and stay as they are.
class PlanBins {
 public:
  explicit PlanBins(const std::vector<PlanBox>& boxes) : boxes_(boxes) {
    PlanBox all{HUGE_VAL, -HUGE_VAL, HUGE_VAL, -HUGE_VAL};
    for (const PlanBox& b : boxes) {
      all = {std::fmin(all.x0, b.x0), std::fmax(all.x1, b.x1), std::fmin(all.y0, b.y0),
             std::fmax(all.y1, b.y1)};
    }
    const double w = all.x1 - all.x0, h = all.y1 - all.y0;
    x0_ = all.x0;
    y0_ = all.y0;
    const double cell =
        std::sqrt(std::fmax(w * h, 1e-6 * (w * w + h * h)) / static_cast<double>(boxes.size() + 1));
    if (cell > 0) {
      per_ = 1 / cell;
      nx_ = static_cast<std::size_t>(std::clamp(w * per_ + 1, 1.0, 4096.0));
      ny_ = static_cast<std::size_t>(std::clamp(h * per_ + 1, 1.0, 4096.0));
    }
    start_.assign(nx_ * ny_ + 2, 0);
    for (const PlanBox& b : boxes) each_cell(b, [&](std::size_t c) { ++start_[c + 2]; });
    for (std::size_t c = 2; c < start_.size(); ++c) start_[c] += start_[c - 1];
    items_.resize(start_.back());
    for (std::uint32_t k = 0; k < boxes.size(); ++k)
      each_cell(boxes[k], [&](std::size_t c) { items_[start_[c + 1]++] = k; });
  }

  // Calls see(number) for each box that reaches into `box`; more than once for some.
  template <class See>
  void over(const PlanBox& box, const See& see) const {
    if (items_.empty()) return;
    each_cell(box, [&](std::size_t c) {
      for (std::uint32_t k = start_[c]; k < start_[c + 1]; ++k) {
        const PlanBox& b = boxes_[items_[k]];
        if (b.x1 < box.x0 || b.x0 > box.x1 || b.y1 < box.y0 || b.y0 > box.y1) continue;
        see(items_[k]);
      }
    });
  }

 private:
  template <class Do>
  void each_cell(const PlanBox& b, const Do& act) const {
    const auto cell = [&](double v, double low, std::size_t n) {
      return static_cast<std::size_t>(
          std::clamp((v - low) * per_, 0.0, static_cast<double>(n - 1)));
    };
    const std::size_t i1 = cell(b.x1, x0_, nx_), j1 = cell(b.y1, y0_, ny_);
    for (std::size_t j = cell(b.y0, y0_, ny_); j <= j1; ++j) {
      for (std::size_t i = cell(b.x0, x0_, nx_); i <= i1; ++i) act(j * nx_ + i);
    }
  }

  const std::vector<PlanBox>& boxes_;
  double x0_ = 0, y0_ = 0, per_ = 0;
  std::size_t nx_ = 1, ny_ = 1;
  std::vector<std::uint32_t> start_, items_;
};

}  // namespace diesink
