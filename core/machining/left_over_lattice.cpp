// The points at which what stays is looked at: a lattice, and points between where slopes and edges
// ask for them.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/machining/left_over.h"
#include "core/parallel.h"

namespace diesink {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kMostPoints = 2e6;
// Points to a side of a cell where an edge passes.
constexpr int kEdgeParts = 4;
// Normals of a cell's corners further apart than this, some 6 degrees, have an edge between them.
constexpr double kEdgeCosine = 0.995;
// Heights further apart than slopes explain, in spacings: there is a wall between.
constexpr double kWallHeight = 0.5;
// Of the lattice's step, half the chord that the rim cuts off a line; of what may stay, the most
// that its way inward costs.
constexpr double kRimChord = 0.75, kRimPart = 0.05;

}  // namespace

void LeftOver::Points::resize(std::size_t count) {
  z.assign(count, std::numeric_limits<double>::quiet_NaN());
  left.assign(count, -kInfinity);
  nx.assign(count, 0);
  ny.assign(count, 0);
  nz.assign(count, 1);
  fit.assign(count, Fit::kUnknown);
}

void LeftOver::Points::take(std::size_t k, double height, const Vec3& normal) {
  z[k] = height;
  left[k] = kInfinity;
  nx[k] = static_cast<float>(normal.x());
  ny[k] = static_cast<float>(normal.y());
  nz[k] = static_cast<float>(normal.z());
}

LeftOver::LeftOver(const CompoundSurface& surface, const OffsetSurface& offset,
                   const PointDrop& drop, const CutterShape& cutter, const FrameDomain& domain,
                   const LeftOverLimits& limits, double spacing, int threads,
                   std::span<const PlanBox> places)
    : surface_(&surface),
      offset_(&offset),
      drop_(&drop),
      cutter_(cutter),
      domain_(domain),
      limits_(limits),
      threads_(threads) {
  double x1 = -kInfinity, y1 = -kInfinity;
  x0_ = y0_ = kInfinity;
  for (const Vec2& c : domain.corners()) {
    x0_ = std::min(x0_, c.x());
    y0_ = std::min(y0_, c.y());
    x1 = std::max(x1, c.x());
    y1 = std::max(y1, c.y());
  }
  if (!places.empty()) {
    PlanBox all{kInfinity, -kInfinity, kInfinity, -kInfinity};
    for (const PlanBox& place : places) {
      all.x0 = std::min(all.x0, place.x0);
      all.x1 = std::max(all.x1, place.x1);
      all.y0 = std::min(all.y0, place.y0);
      all.y1 = std::max(all.y1, place.y1);
    }
    x0_ = std::max(x0_, all.x0);
    y0_ = std::max(y0_, all.y0);
    x1 = std::max(x0_, std::min(x1, all.x1));
    y1 = std::max(y0_, std::min(y1, all.y1));
  }
  step_ = std::max(spacing, std::sqrt((x1 - x0_) * (y1 - y0_) / kMostPoints));
  // The last column and row lie on the domain's sides, as the first do.
  const auto divide = [&](double length, std::size_t& points, double& step) {
    const double parts = std::ceil(length / step_);
    points = static_cast<std::size_t>(parts) + 1;
    step = parts > 0 ? length / parts : step_;
  };
  divide(x1 - x0_, columns_, dx_);
  divide(y1 - y0_, rows_, dy_);
  lattice_.resize(columns_ * rows_);
  const double R = cutter.radius();
  reach_ = {x0_ - R, x(columns_ - 1) + R, y0_ - R, y(rows_ - 1) + R};
  hair_ = 1e-9 * R;
  rim_ = std::min(kRimChord * kRimChord * step_ * step_ / (2 * R), kRimPart * limits.limit) / R;
  parallel_blocks(rows_, kRowsABlock, threads_, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t j = begin; j < end; ++j) {
      const Span inside = domain_.pass(y(j));
      std::vector<bool> asked(columns_, places.empty());
      for (const PlanBox& place : places) {
        if (y(j) < place.y0 || y(j) > place.y1) continue;
        for (std::size_t i = 0; i < columns_; ++i) {
          if (x(i) >= place.x0 && x(i) <= place.x1) asked[i] = true;
        }
      }
      for (std::size_t i = 0; i < columns_; ++i) {
        if (!asked[i] || x(i) < inside.x0 - hair_ || x(i) > inside.x1 + hair_) continue;
        const Vec3 p = offset.from_frame({x(i), y(j), 0});
        const std::optional<CcDatum> cc = surface.at(p.x(), p.y());
        if (cc) lattice_.take(j * columns_ + i, cc->z, offset.to_frame(cc->n));
      }
    }
  });
  add_between(surface);
}

std::array<int, 2> LeftOver::parts_of(std::size_t i, std::size_t j) const {
  const std::size_t k = j * columns_ + i;
  const std::array<std::size_t, 4> corner{k, k + 1, k + columns_, k + columns_ + 1};
  double gx = 0, gy = 0, low = kInfinity, high = -kInfinity, least = 1;
  std::array<Vec3, 4> n;
  for (std::size_t c = 0; c < 4; ++c) {
    const std::size_t at = corner[c];
    if (std::isnan(lattice_.z[at])) return {1, 1};
    n[c] = Vec3(static_cast<double>(lattice_.nx[at]), static_cast<double>(lattice_.ny[at]),
                static_cast<double>(lattice_.nz[at]));
    gx = std::max(gx, std::fabs(n[c].x()) / std::max(n[c].z(), 1e-3));
    gy = std::max(gy, std::fabs(n[c].y()) / std::max(n[c].z(), 1e-3));
    low = std::min(low, lattice_.z[at]);
    high = std::max(high, lattice_.z[at]);
    for (std::size_t d = 0; d < c; ++d) least = std::min(least, n[c].dot(n[d]));
  }
  const bool edge = least < kEdgeCosine || high - low > (gx + gy + kWallHeight) * step_;
  const auto parts = [&](double slope) {
    const double along = std::min(std::hypot(1, slope), 1e3);
    // What a sharp corner leaves on a slope falls off to both sides as steeply as the slope.
    const double ridges = cutter_.corner() < limits_.limit
                              ? step_ * (slope / along) / (2 * (limits_.limit - limits_.call))
                              : 0;
    const int count = static_cast<int>(std::max(std::round(along), std::ceil(ridges)));
    return std::min(std::max(count, edge ? kEdgeParts : 1), most_parts_);
  };
  return {parts(gx), parts(gy)};
}

void LeftOver::add_between(const CompoundSurface& surface) {
  const std::size_t bands = rows_ - 1, cells = columns_ - 1;
  between_.begin.assign(rows_, 0);
  for (;; most_parts_ /= 2) {
    parallel_blocks(bands, kRowsABlock, threads_, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t j = begin; j < end; ++j) {
        std::size_t count = 0;
        for (std::size_t i = 0; i < cells; ++i) {
          const auto [nx, ny] = parts_of(i, j);
          if (nx * ny > 1) count += static_cast<std::size_t>(nx * ny);
        }
        between_.begin[j + 1] = count;
      }
    });
    std::size_t all = 0;
    for (const std::size_t count : between_.begin) all += count;
    if (static_cast<double>(all) <= kMostPoints) break;
  }
  for (std::size_t j = 0; j < bands; ++j) between_.begin[j + 1] += between_.begin[j];
  const std::size_t all = between_.begin.back();
  between_.resize(all);
  between_.x.resize(all);
  between_.y.resize(all);
  between_.area.resize(all);
  parallel_blocks(bands, kRowsABlock, threads_, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t j = begin; j < end; ++j) {
      std::size_t k = between_.begin[j];
      for (std::size_t i = 0; i < cells; ++i) {
        const auto [nx, ny] = parts_of(i, j);
        if (nx * ny == 1) continue;
        for (int a = 0; a < nx; ++a) {
          for (int b = 0; b < ny; ++b, ++k) {
            between_.x[k] = x(i) + (a + 0.5) / nx * dx_;
            between_.y[k] = y(j) + (b + 0.5) / ny * dy_;
            between_.area[k] = static_cast<float>(dx_ * dy_ / (nx * ny));
            const Vec3 p = offset_->from_frame({between_.x[k], between_.y[k], 0});
            const std::optional<CcDatum> cc = surface.at(p.x(), p.y());
            if (cc) between_.take(k, cc->z, offset_->to_frame(cc->n));
          }
        }
      }
    }
  });
  tiles_ = (columns_ + kTile - 1) / kTile;
  highest_.assign(tiles_ * ((rows_ + kTile - 1) / kTile), kInfinity);
  between_start_.resize(bands * (tiles_ + 1));
  for (std::size_t j = 0; j < bands; ++j) {
    std::size_t k = between_.begin[j];
    for (std::size_t t = 0; t <= tiles_; ++t) {
      between_start_[j * (tiles_ + 1) + t] = k;
      const double end = t < tiles_ ? x0_ + static_cast<double>((t + 1) * kTile) * dx_ : kInfinity;
      while (k < between_.begin[j + 1] && (between_.x[k] < end || t + 1 >= tiles_)) ++k;
    }
  }
}

std::array<std::size_t, 2> LeftOver::between_of(std::size_t j, std::size_t tile) const {
  const std::size_t at = j * (tiles_ + 1) + tile;
  return {between_start_[at], between_start_[at + 1]};
}

// What is not of points between its own.
double LeftOver::own_area(std::size_t k) const {
  const std::size_t i = k % columns_, j = k / columns_;
  int quarters = 0;
  for (const std::size_t a : {i - 1, i}) {
    for (const std::size_t b : {j - 1, j}) {
      const bool divided = a < columns_ - 1 && b < rows_ - 1 && parts_of(a, b) != std::array{1, 1};
      quarters += divided ? 0 : 1;
    }
  }
  return 0.25 * quarters * dx_ * dy_;
}

}  // namespace diesink
