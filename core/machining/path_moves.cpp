// SPDX-License-Identifier: Apache-2.0
#include "core/machining/path_moves.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace diesink {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Of a bin, by how much it reaches beyond itself: a move on the line between two is in both.
constexpr double kBinHair = 1e-6;
// Moves side by side in a bin; bins, of the radius.
constexpr double kBinMoves = 1.5, kLeastBin = 1.0 / 64, kMostBin = 1.0 / 8;

}  // namespace

template <class Do>
void PathMoves::each_bin(const PassedMove& move, const Do& act) const {
  const auto bin = [&](double at, double from, std::size_t count) {
    return static_cast<std::size_t>(
        std::clamp((at - from) * bins_.per, 0.0, static_cast<double>(count - 1)));
  };
  const double hair = kBinHair / bins_.per;
  for (std::size_t j = bin(move.y0 - hair, bins_.y0, bins_.rows),
                   last = bin(move.y1 + hair, bins_.y0, bins_.rows);
       j <= last; ++j) {
    const double low = bins_.y0 + static_cast<double>(j) / bins_.per;
    const auto [x0, x1] = move.over(low - hair, low + 1 / bins_.per + hair);
    for (std::size_t i = bin(x0 - hair, bins_.x0, bins_.columns),
                     end = bin(x1 + hair, bins_.x0, bins_.columns);
         i <= end; ++i) {
      act(j * bins_.columns + i);
    }
  }
}

void PathMoves::bin() {
  constexpr double kMostBins = 1e6;
  double length = 0;
  PlanBox all{kInfinity, -kInfinity, kInfinity, -kInfinity};
  for (const PassedMove& move : moves_) {
    all = {std::min({all.x0, move.from.x(), move.from.x() + move.d.x()}),
           std::max({all.x1, move.from.x(), move.from.x() + move.d.x()}), std::min(all.y0, move.y0),
           std::max(all.y1, move.y1)};
    length += move.length;
  }
  bins_ = {};
  if (moves_.empty()) return;
  // About as wide as the moves lie apart, so that those around a bin are among the nearest.
  const double area = (all.x1 - all.x0) * (all.y1 - all.y0), R = cutter_.radius();
  const double apart = length > 0 ? area / length : R;
  const double cell = std::max(std::clamp(kBinMoves * apart, kLeastBin * R, kMostBin * R),
                               std::sqrt(area / kMostBins));
  bins_.x0 = all.x0;
  bins_.y0 = all.y0;
  bins_.per = 1 / cell;
  bins_.columns = static_cast<std::size_t>((all.x1 - all.x0) * bins_.per) + 1;
  bins_.rows = static_cast<std::size_t>((all.y1 - all.y0) * bins_.per) + 1;
  const std::size_t count = bins_.columns * bins_.rows;
  bins_.begin.assign(count + 2, 0);
  bins_.levels.push_back({bins_.columns, bins_.rows, std::vector<double>(count, kInfinity)});
  std::vector<double>& low = bins_.levels.front().low;
  for (const PassedMove& move : moves_) {
    each_bin(move, [&](std::size_t b) {
      ++bins_.begin[b + 2];
      low[b] = std::min(low[b], move.low);
    });
  }
  for (std::size_t b = 2; b < bins_.begin.size(); ++b) bins_.begin[b] += bins_.begin[b - 1];
  bins_.items.resize(bins_.begin.back());
  for (std::uint32_t k = 0; k < moves_.size(); ++k) {
    each_bin(moves_[k], [&](std::size_t b) { bins_.items[bins_.begin[b + 1]++] = k; });
  }
  while (bins_.levels.back().low.size() > 1) {
    const Level& under = bins_.levels.back();
    Level level{(under.columns + 1) / 2, (under.rows + 1) / 2, {}};
    level.low.assign(level.columns * level.rows, kInfinity);
    for (std::size_t k = 0; k < under.low.size(); ++k) {
      double& least = level.low[k / under.columns / 2 * level.columns + k % under.columns / 2];
      least = std::min(least, under.low[k]);
    }
    bins_.levels.push_back(std::move(level));
  }
}

double PathMoves::height(std::uint32_t move, const Vec2& p) const {
  double left = kInfinity;
  moves_[move].lower(cutter_, p, left);
  return left;
}

void PathMoves::lowest_of(std::size_t bin, const Vec2& p, std::uint32_t& best,
                          double& below) const {
  for (std::uint32_t k = bins_.begin[bin]; k < bins_.begin[bin + 1]; ++k) {
    const double before = below;
    moves_[bins_.items[k]].lower(cutter_, p, below);
    if (below < before) best = bins_.items[k];
  }
}

void PathMoves::lowest_of(std::size_t level, std::size_t i, std::size_t j, const Vec2& p,
                          std::uint32_t& best, double& below) const {
  if (level == 0) {
    lowest_of(j * bins_.columns + i, p, best, below);
    return;
  }
  // The least that a move in each of the four below may leave over p, the least first.
  const Level& under = bins_.levels[level - 1];
  const double cell = static_cast<double>(std::size_t{1} << (level - 1)) / bins_.per;
  const double hair = kBinHair / bins_.per;
  struct Child {
    double least;
    std::size_t i, j;
  };
  std::array<Child, 4> children;
  std::size_t count = 0;
  for (std::size_t cj = 2 * j; cj < std::min(2 * j + 2, under.rows); ++cj) {
    for (std::size_t ci = 2 * i; ci < std::min(2 * i + 2, under.columns); ++ci) {
      const double low = under.low[cj * under.columns + ci];
      if (!(low < below)) continue;
      const double x = bins_.x0 + static_cast<double>(ci) * cell - hair - p.x();
      const double y = bins_.y0 + static_cast<double>(cj) * cell - hair - p.y();
      const double gap_x = std::max({0.0, x, -x - cell - 2 * hair});
      const double gap_y = std::max({0.0, y, -y - cell - 2 * hair});
      const double gap2 = gap_x * gap_x + gap_y * gap_y;
      if (gap2 > cutter_.radius() * cutter_.radius()) continue;
      const double least = low + cutter_.height(std::sqrt(gap2));
      if (!(least < below)) continue;
      std::size_t at = count++;
      for (; at > 0 && least < children[at - 1].least; --at) children[at] = children[at - 1];
      children[at] = {least, ci, cj};
    }
  }
  for (std::size_t k = 0; k < count && children[k].least < below; ++k) {
    lowest_of(level - 1, children[k].i, children[k].j, p, best, below);
  }
}

std::uint32_t PathMoves::lowest(const Vec2& p, double& below) const {
  std::uint32_t best = kNone;
  if (!moves_.empty()) lowest_of(bins_.levels.size() - 1, 0, 0, p, best, below);
  return best;
}

std::uint32_t PathMoves::lowest_near(const Vec2& tip, const Vec2& p, double& below) const {
  std::uint32_t best = kNone;
  if (moves_.empty()) return best;
  const auto i0 = static_cast<long>(std::floor((tip.x() - bins_.x0) * bins_.per));
  const auto j0 = static_cast<long>(std::floor((tip.y() - bins_.y0) * bins_.per));
  for (long j = std::max(0L, j0 - 1); j <= std::min(j0 + 1, static_cast<long>(bins_.rows) - 1);
       ++j) {
    for (long i = std::max(0L, i0 - 1); i <= std::min(i0 + 1, static_cast<long>(bins_.columns) - 1);
         ++i) {
      lowest_of(static_cast<std::size_t>(j) * bins_.columns + static_cast<std::size_t>(i), p, best,
                below);
    }
  }
  return best;
}

}  // namespace diesink
