// Where a coordinate falls among ascending lines.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

namespace diesink {

// First index in [0, size] whose line is not below a coordinate; lines are evenly spaced far more
// often than not, and then no search is needed.
// Needs: at least one line, ascending, which outlives this.
class LineSearch {
 public:
  explicit LineSearch(std::span<const double> lines)
      : lines_(lines),
        per_length_(lines.size() > 1
                        ? static_cast<double>(lines.size() - 1) / (lines.back() - lines.front())
                        : 0) {}

  [[nodiscard]] std::size_t first_from(double at) const {
    if (!(at > lines_.front())) return 0;
    if (at > lines_.back()) return lines_.size();
    std::size_t k =
        std::min(static_cast<std::size_t>((at - lines_.front()) * per_length_), lines_.size() - 1);
    constexpr int kNear = 4;
    for (int step = 0; step < kNear; ++step) {
      if (lines_[k] < at) {
        ++k;  // stays within: the last line is not below
      } else if (lines_[k - 1] < at) {
        return k;
      } else {
        --k;  // stays above 0: the first line is below
      }
    }
    return static_cast<std::size_t>(std::lower_bound(lines_.begin(), lines_.end(), at) -
                                    lines_.begin());
  }

  // First index whose line is above the coordinate.
  [[nodiscard]] std::size_t first_above(double at) const {
    std::size_t k = first_from(at);
    while (k < lines_.size() && lines_[k] <= at) ++k;
    return k;
  }

  [[nodiscard]] std::span<const double> lines() const { return lines_; }

 private:
  std::span<const double> lines_;
  double per_length_;
};

}  // namespace diesink
