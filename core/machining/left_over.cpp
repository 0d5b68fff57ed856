// SPDX-License-Identifier: Apache-2.0
#include "core/machining/left_over.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/machining/interference.h"
#include "core/parallel.h"

namespace diesink {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kMostPoints = 2e6;
constexpr std::size_t kMovesATime = 8192;
constexpr std::size_t kRowsABlock = 16;

// The lowest height of a cutter over a point beside a straight move that begins at the height z:
// the point lies u along the move and w across it. Any position gives an upper bound, so that the
// search for a bull nose may stop early.
double lowest_over(const CutterShape& cutter, double z, double slope, double length, double u,
                   double w2) {
  const double R = cutter.radius(), half = std::sqrt(std::max(0.0, R * R - w2));
  const double first = std::max(0.0, u - half), last = std::min(length, u + half);
  if (first > last) return kInfinity;
  const auto at = [&](double s) {
    const double rho = std::sqrt(w2 + (s - u) * (s - u));
    return z + slope * s + cutter.height(std::min(rho, R));
  };
  if (slope == 0) return at(std::clamp(u, first, last));
  if (cutter.corner() <= 0) return at(slope > 0 ? first : last);
  if (cutter.flat() <= 0) {
    return at(std::clamp(u - slope / std::sqrt(1 + slope * slope) * half, first, last));
  }
  double low = first, high = last;  // the height is convex along the move
  for (int k = 0; k < 24; ++k) {
    const double a = low + (high - low) / 3, b = high - (high - low) / 3;
    (at(a) < at(b) ? high : low) = at(a) < at(b) ? b : a;
  }
  return std::min({at(first), at(last), at((low + high) / 2)});
}

}  // namespace

LeftOver::LeftOver(const CompoundSurface& surface, const OffsetSurface& offset,
                   const PointDrop& drop, const CutterShape& cutter, const FrameDomain& domain,
                   const LeftOverLimits& limits, double spacing, int threads)
    : offset_(&offset),
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
  step_ = std::max(spacing, std::sqrt((x1 - x0_) * (y1 - y0_) / kMostPoints));
  columns_ = static_cast<std::size_t>(std::floor((x1 - x0_) / step_)) + 1;
  rows_ = static_cast<std::size_t>(std::floor((y1 - y0_) / step_)) + 1;
  const std::size_t count = columns_ * rows_;
  z_.assign(count, std::numeric_limits<double>::quiet_NaN());
  left_.assign(count, kInfinity);
  nx_.assign(count, 0);
  ny_.assign(count, 0);
  nz_.assign(count, 1);
  fit_.assign(count, Fit::kUnknown);
  const double hair = 1e-9 * cutter.radius();
  parallel_blocks(rows_, kRowsABlock, threads_, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t j = begin; j < end; ++j) {
      const Span inside = domain_.pass(y(j));
      for (std::size_t i = 0; i < columns_; ++i) {
        if (x(i) < inside.x0 - hair || x(i) > inside.x1 + hair) continue;
        const Vec3 p = offset.from_frame({x(i), y(j), 0});
        const std::optional<CcDatum> cc = surface.at(p.x(), p.y());
        if (!cc) continue;
        const Vec3 n = offset.to_frame(cc->n);
        const std::size_t k = j * columns_ + i;
        z_[k] = cc->z;
        nx_[k] = static_cast<float>(n.x());
        ny_[k] = static_cast<float>(n.y());
        nz_[k] = static_cast<float>(n.z());
      }
    }
  });
}

void LeftOver::cut(const Vec3& from, const Vec3& to) {
  waiting_.push_back({from, to});
  if (waiting_.size() >= kMovesATime) flush();
}

void LeftOver::flush() {
  if (waiting_.empty()) return;
  const double R = cutter_.radius();
  parallel_blocks(rows_, kRowsABlock, threads_, [&](std::size_t begin, std::size_t end, int) {
    const double low = y(begin), high = y(end - 1);
    for (const Move& move : waiting_) {
      const double y0 = std::min(move.from.y(), move.to.y()) - R;
      const double y1 = std::max(move.from.y(), move.to.y()) + R;
      if (y0 > high || y1 < low) continue;
      for (std::size_t j = begin; j < end; ++j) {
        if (y(j) >= y0 && y(j) <= y1) cut_row(j, move);
      }
    }
  });
  waiting_.clear();
}

void LeftOver::cut_row(std::size_t j, const Move& move) {
  const double R = cutter_.radius(), at_y = y(j);
  const Vec2 from = move.from.head<2>(), d = (move.to - move.from).head<2>();
  // The part of the move within a radius of the row.
  double t0 = 0, t1 = 1;
  if (d.y() != 0) {
    const double ta = (at_y - R - from.y()) / d.y(), tb = (at_y + R - from.y()) / d.y();
    t0 = std::clamp(std::min(ta, tb), 0.0, 1.0);
    t1 = std::clamp(std::max(ta, tb), 0.0, 1.0);
  }
  const double xa = from.x() + t0 * d.x(), xb = from.x() + t1 * d.x();
  const double first = std::ceil((std::min(xa, xb) - R - x0_) / step_);
  const double last = std::floor((std::max(xa, xb) + R - x0_) / step_);
  if (last < 0 || first > static_cast<double>(columns_ - 1)) return;
  const double length = d.norm(), low = std::min(move.from.z(), move.to.z());
  const Vec2 along = length > 0 ? Vec2(d / length) : Vec2(1, 0);
  const double slope = length > 0 ? (move.to.z() - move.from.z()) / length : 0;
  const double z = length > 0 ? move.from.z() : low;
  const auto end = static_cast<std::size_t>(std::min(last, static_cast<double>(columns_ - 1)));
  for (auto i = static_cast<std::size_t>(std::max(first, 0.0)); i <= end; ++i) {
    double& left = left_[j * columns_ + i];
    if (low >= left) continue;
    const double ox = x(i) - from.x(), oy = at_y - from.y();
    const double u = ox * along.x() + oy * along.y(), w = oy * along.x() - ox * along.y();
    const double off = u - std::clamp(u, 0.0, length), near2 = w * w + off * off;
    if (near2 > R * R || low + cutter_.height(std::sqrt(near2)) >= left) continue;
    left = std::min(left, lowest_over(cutter_, z, slope, length, u, w * w));
  }
}

double LeftOver::stays(std::size_t k) const {
  return std::isnan(z_[k]) ? 0 : (left_[k] - z_[k]) * static_cast<double>(nz_[k]);
}

Vec3 LeftOver::tip(std::size_t k) const {
  const Vec3 p(x(k % columns_), y(k / columns_), z_[k]);
  const Vec3 n(static_cast<double>(nx_[k]), static_cast<double>(ny_[k]),
               static_cast<double>(nz_[k]));
  return tip_of(offset_->cutter(), {p, n});
}

bool LeftOver::fits(std::size_t k) {
  if (fit_[k] == Fit::kUnknown) {
    const Vec3 at = tip(k);
    const Span inside = domain_.pass(at.y());
    const double allowed = at.z() + limits_.touch;
    const bool yes = at.y() >= domain_.low() && at.y() <= domain_.high() && at.x() >= inside.x0 &&
                     at.x() <= inside.x1 &&
                     drop_->at(at.x(), at.y(), std::nextafter(allowed, kInfinity)) <= allowed;
    fit_[k] = yes ? Fit::kYes : Fit::kNo;
  }
  return fit_[k] == Fit::kYes;
}

std::vector<std::vector<Vec3>> LeftOver::open_runs(std::size_t stride) {
  flush();
  const std::size_t taken = (rows_ + stride - 1) / stride;
  const double far = cutter_.radius() / 2 + 4 * step_;
  constexpr std::size_t kGap = 4;
  std::vector<std::vector<std::vector<Vec3>>> found(taken);
  parallel_blocks(taken, 1, threads_, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t r = begin; r < end; ++r) {
      std::size_t last = 0;
      for (std::size_t i = 0; i < columns_; ++i) {
        const std::size_t k = r * stride * columns_ + i;
        if (!(stays(k) > limits_.call) || !fits(k)) continue;
        Vec3 at = tip(k);
        at.z() = drop_->at(at.x(), at.y());
        auto& runs = found[r];
        if (runs.empty() || i > last + kGap || (at - runs.back().back()).norm() > far) {
          runs.emplace_back();
        }
        runs.back().push_back(at);
        last = i;
      }
    }
  });
  std::vector<std::vector<Vec3>> all;
  for (auto& runs : found) {
    std::move(runs.begin(), runs.end(), std::back_inserter(all));
  }
  return all;
}

LeftOver::Rest LeftOver::rest() {
  flush();
  std::vector<Rest> of(rows_);
  parallel_blocks(rows_, kRowsABlock, threads_, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t j = begin; j < end; ++j) {
      for (std::size_t k = j * columns_; k < (j + 1) * columns_; ++k) {
        if (!(stays(k) > limits_.limit) || !fits(k)) continue;
        of[j].area += step_ * step_;
        of[j].height = std::max(of[j].height, stays(k));
      }
    }
  });
  Rest sum;
  for (const Rest& row : of) {
    sum.area += row.area;
    sum.height = std::max(sum.height, row.height);
  }
  return sum;
}

}  // namespace diesink
