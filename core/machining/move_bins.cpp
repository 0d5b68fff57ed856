// SPDX-License-Identifier: Apache-2.0
#include "core/machining/move_bins.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace diesink {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kMostBins = 1e6;

}  // namespace

template <class Do>
void MoveBins::each_bin(const PassedMove& move, const Do& act) const {
  const auto bin = [&](double at, double from, std::size_t count) {
    return static_cast<std::size_t>(
        std::clamp((at - from) * per_, 0.0, static_cast<double>(count - 1)));
  };
  const double end_x = x0_ + static_cast<double>(columns_) / per_;
  const double end_y = y0_ + static_cast<double>(rows_) / per_;
  if (move.y1 + near_ < y0_ || move.y0 - near_ > end_y) return;
  const std::size_t last = bin(move.y1 + near_, y0_, rows_);
  for (std::size_t j = bin(move.y0 - near_, y0_, rows_); j <= last; ++j) {
    const double low = y0_ + static_cast<double>(j) / per_, high = low + 1 / per_;
    const auto [xa, xb] = move.over(low - near_, high + near_);
    if (xb + near_ < x0_ || xa - near_ > end_x) continue;
    const std::size_t right = bin(xb + near_, x0_, columns_);
    for (std::size_t i = bin(xa - near_, x0_, columns_); i <= right; ++i) act(j * columns_ + i);
  }
}

MoveBins::MoveBins(std::span<const PassedMove> moves, const PlanBox& box, double near)
    : moves_(moves), near_(near) {
  PlanBox all{kInfinity, -kInfinity, kInfinity, -kInfinity};
  for (const PassedMove& move : moves) {
    const double x = move.from.x() + move.d.x();
    all = {std::min({all.x0, move.from.x(), x}), std::max({all.x1, move.from.x(), x}),
           std::min(all.y0, move.y0), std::max(all.y1, move.y1)};
  }
  all = {std::max(all.x0 - near, box.x0), std::min(all.x1 + near, box.x1),
         std::max(all.y0 - near, box.y0), std::min(all.y1 + near, box.y1)};
  begin_.assign(1, 0);
  if (!(all.x1 >= all.x0 && all.y1 >= all.y0)) return;
  x0_ = all.x0;
  y0_ = all.y0;
  const double wide = all.x1 - all.x0, high = all.y1 - all.y0;
  per_ = 1 / std::max(near, std::sqrt((wide + near) * (high + near) / kMostBins));
  columns_ = static_cast<std::size_t>(wide * per_) + 1;
  rows_ = static_cast<std::size_t>(high * per_) + 1;
  begin_.assign(columns_ * rows_ + 1, 0);
  for (const PassedMove& move : moves) {
    each_bin(move, [&](std::size_t bin) { ++begin_[bin + 1]; });
  }
  for (std::size_t k = 1; k < begin_.size(); ++k) begin_[k] += begin_[k - 1];
  items_.resize(begin_.back());
  std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
  for (std::size_t m = 0; m < moves.size(); ++m) {
    each_bin(moves[m],
             [&](std::size_t bin) { items_[next[bin]++] = static_cast<std::uint32_t>(m); });
  }
}

MoveBins::Nearest MoveBins::nearest(const Vec2& p) const {
  Nearest out;
  const double u = (p.x() - x0_) * per_, v = (p.y() - y0_) * per_;
  if (!(u >= 0 && v >= 0 && u < static_cast<double>(columns_) && v < static_cast<double>(rows_))) {
    return out;
  }
  const std::size_t bin = static_cast<std::size_t>(v) * columns_ + static_cast<std::size_t>(u);
  double first = kInfinity, second = kInfinity;
  for (std::uint32_t k = begin_[bin]; k < begin_[bin + 1]; ++k) {
    const PassedMove& move = moves_[items_[k]];
    const Vec2 off = p - move.from;
    const double along = std::clamp(off.dot(move.along), 0.0, move.length);
    const double far2 = (off - along * move.along).squaredNorm();
    if (!(far2 < second)) continue;
    const Vec2 at = move.from + along * move.along;
    const Vec3 tip(at.x(), at.y(), move.z + along * move.slope);
    if (far2 < first) {
      second = first;
      out.tip[1] = out.tip[0];
      first = far2;
      out.tip[0] = tip;
    } else {
      second = far2;
      out.tip[1] = tip;
    }
    out.count = std::min(out.count + 1, 2);
  }
  return out;
}

}  // namespace diesink
