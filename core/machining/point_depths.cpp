// SPDX-License-Identifier: Apache-2.0
#include "core/machining/point_depths.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/machining/swept_heights.h"
#include "core/parallel.h"

namespace diesink {
namespace {

constexpr std::size_t kPointsABlock = 64;

}  // namespace

PointDepths::PointDepths(const CutterShape& cutter, std::vector<Vec3> points)
    : cutter_(cutter), points_(std::move(points)), order_(points_.size()), depths_(points_.size()) {
  std::iota(order_.begin(), order_.end(), 0U);
  // Squares of about a radius a side, so that a block of points lies together.
  const auto cell = [&](std::uint32_t k, int axis) {
    return std::floor(points_[k][axis] / cutter_.radius());
  };
  std::sort(order_.begin(), order_.end(), [&](std::uint32_t p, std::uint32_t q) {
    if (cell(p, 1) != cell(q, 1)) return cell(p, 1) < cell(q, 1);
    if (cell(p, 0) != cell(q, 0)) return cell(p, 0) < cell(q, 0);
    return p < q;
  });
}

void PointDepths::add(std::span<const SweepMove> moves, int threads) {
  const double R = cutter_.radius();
  parallel_blocks(
      order_.size(), kPointsABlock, threads, [&](std::size_t begin, std::size_t end, int) {
        Vec3 low = points_[order_[begin]], high = low;
        for (std::size_t k = begin; k < end; ++k) {
          low = low.cwiseMin(points_[order_[k]]);
          high = high.cwiseMax(points_[order_[k]]);
        }
        for (const SweepMove& move : moves) {
          if (std::min(move.from.x(), move.to.x()) - R > high.x() ||
              std::max(move.from.x(), move.to.x()) + R < low.x() ||
              std::min(move.from.y(), move.to.y()) - R > high.y() ||
              std::max(move.from.y(), move.to.y()) + R < low.y() ||
              std::min(move.from.z(), move.to.z()) >= high.z()) {
            continue;
          }
          for (std::size_t k = begin; k < end; ++k) {
            const Vec3& p = points_[order_[k]];
            double& depth = depths_[order_[k]];
            // Straight down is the most it can be.
            if (p.z() - swept_height(cutter_, move, p.x(), p.y()) <= depth) continue;
            const double ceiling =
                std::max({p.z(), move.from.z(), move.to.z()}) + 4 * cutter_.radius();
            depth = std::max(depth, sweep_depth(cutter_, move, {p, p, p}, depth, ceiling).found);
          }
        }
      });
}

}  // namespace diesink
