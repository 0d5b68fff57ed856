// SPDX-License-Identifier: Apache-2.0
#include "core/machining/left_over.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/machining/interference.h"
#include "core/machining/move_bins.h"
#include "core/machining/passed_move.h"
#include "core/machining/tool_path_plan.h"
#include "core/parallel.h"

namespace diesink {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kMovesATime = 32768;
// A run goes on over so many columns.
constexpr std::size_t kGap = 4;

}  // namespace

void LeftOver::cut(const Vec3& from, const Vec3& to) {
  if (std::max(from.x(), to.x()) < reach_.x0 || std::min(from.x(), to.x()) > reach_.x1 ||
      std::max(from.y(), to.y()) < reach_.y0 || std::min(from.y(), to.y()) > reach_.y1) {
    return;
  }
  waiting_.push_back({from, to});
  if (waiting_.size() >= kMovesATime) flush();
}

void LeftOver::flush() {
  if (waiting_.empty()) return;
  const double R = cutter_.radius();
  std::vector<PassedMove> moves;
  moves.reserve(waiting_.size());
  for (const Move& move : waiting_) moves.emplace_back(move.from, move.to);
  waiting_.clear();
  // A tip that leaves no more than `call` on level ground is no further off than this.
  const MoveBins bins(moves, reach_,
                      std::clamp(std::sqrt(2 * cutter_.corner() * limits_.call), step_, R / 2));
  const std::size_t blocks = (rows_ + kTile - 1) / kTile;
  parallel_blocks(blocks, 1, threads_, [&](std::size_t begin, std::size_t end, int) {
    std::vector<PassedMove> near;
    for (std::size_t block = begin; block < end; ++block) {
      const double low = y(block * kTile), high = y(std::min(block * kTile + kTile, rows_ - 1));
      near.clear();
      for (const PassedMove& move : moves) {
        if (move.y0 - R <= high && move.y1 + R >= low) near.push_back(move);
      }
      const auto off = [&](const PassedMove& m) { return std::fabs(m.y0 + m.y1 - low - high); };
      std::stable_sort(near.begin(), near.end(),
                       [&](const PassedMove& p, const PassedMove& q) { return off(p) < off(q); });
      cut_block(block, near, bins);
    }
  });
}

void LeftOver::cut_block(std::size_t block, std::span<const PassedMove> moves,
                         const MoveBins& bins) {
  const double R = cutter_.radius();
  const std::size_t j0 = block * kTile, j1 = std::min(j0 + kTile, rows_ - 1);
  std::vector<OpenTile> tiles(tiles_);
  for (const PassedMove& move : moves) {
    const auto [xa, xb] = move.over(y(j0) - R, y(j1) + R);
    if (xb + R < x0_ || xa - R > x(columns_ - 1)) continue;
    const auto tile_of = [&](double at) {
      return static_cast<std::size_t>(
                 std::clamp(std::floor((at - x0_) / dx_), 0.0, static_cast<double>(columns_ - 1))) /
             kTile;
    };
    for (std::size_t t = tile_of(xa - R), last = tile_of(xb + R); t <= last; ++t) {
      double& top = highest_[block * tiles_ + t];
      if (move.low >= top) continue;
      const PlanBox box{x(t * kTile), x(std::min(t * kTile + kTile, columns_ - 1)), y(j0), y(j1)};
      const double gap = move.gap(box);
      if (gap > R || move.low + cutter_.height(gap) >= top) continue;
      OpenTile& tile = tiles[t];
      if (!tile.taken) take_open(block, t, bins, tile);
      top = cut_tile(tile, move);
    }
  }
  for (const OpenTile& tile : tiles) {
    for (const OpenPart& part : tile.parts) {
      for (std::size_t k = part.begin; k < part.end; ++k) {
        *tile.points[k].kept = tile.points[k].left;
      }
    }
  }
}

void LeftOver::take_open(std::size_t block, std::size_t t, const MoveBins& bins, OpenTile& tile) {
  tile.taken = true;
  Between& between = between_[block * tiles_ + t];
  const std::size_t i0 = t * kTile, i1 = std::min(i0 + kTile, columns_);
  const auto add = [&](Points& points, std::size_t k, const Vec2& at) {
    const double done = points.z[k] + static_cast<double>(points.most[k]);
    if (!(points.left[k] > done) || points.fit[k] == Fit::kDone) return;
    const MoveBins::Nearest near = bins.nearest(tip(points, k, at).head<2>());
    for (int m = 0; m < near.count; ++m) {
      const double rho2 = (near.tip[m].head<2>() - at).squaredNorm();
      if (rho2 > cutter_.radius() * cutter_.radius()) continue;
      const double left = near.tip[m].z() + cutter_.height(std::sqrt(rho2));
      if (!(left < points.left[k])) continue;
      points.left[k] = left;
      if (left <= done) return;
    }
    tile.points.push_back({at, points.left[k], done, &points.left[k]});
  };
  for (std::size_t j = block * kTile, end = std::min(j + kTile, rows_ - 1); j < end; ++j) {
    for (std::size_t i = i0; i < std::min(i1, columns_ - 1); ++i) {
      Cell& cell = cells_[j * columns_ + i];
      // Where the corners alone are asked, every other cell of every other row has them all.
      if (!cell.open && (i % 2 != 0 || j % 2 != 0)) continue;
      const bool whole = cell.smooth && cover(i, j, bins);
      if (cell.open && !whole) add_between(i, j);
      cell.open = false;
    }
  }
  const std::size_t j0 = block * kTile, j1 = std::min(j0 + kTile, rows_);
  for (std::size_t b = j0; b < j1; b += kPart) {
    for (std::size_t a = i0; a < i1; a += kPart) {
      OpenPart part{
          {x(a), x(std::min(a + kPart, columns_ - 1)), y(b), y(std::min(b + kPart, rows_ - 1))},
          tile.points.size(),
          0,
          -kInfinity};
      for (std::size_t j = b; j < std::min(b + kPart, j1); ++j) {
        for (std::size_t i = a; i < std::min(a + kPart, i1); ++i) {
          add(lattice_, j * columns_ + i, beyond_lattice(i, j));
          if (between.begin.empty()) continue;
          const std::size_t k = between.begin[(j - j0) * kTile + i - i0];
          if (k == kNone) continue;
          const Cell& cell = cells_[j * columns_ + i];
          if (cell.border) {
            std::size_t p = k;
            for (const Vec2& at : beyond_ends(i, j, between)) add(between, p++, at);
            continue;
          }
          for (std::size_t p = k; p < k + cell.points(); ++p) {
            add(between, p, {between.x[p], between.y[p]});
          }
        }
      }
      part.end = tile.points.size();
      for (std::size_t p = part.begin; p < part.end; ++p) {
        part.top = std::max(part.top, tile.points[p].left);
      }
      if (part.end > part.begin) tile.parts.push_back(part);
    }
  }
}

bool LeftOver::cover(std::size_t i, std::size_t j, const MoveBins& bins) {
  const std::size_t k = j * columns_ + i;
  const std::array<std::size_t, 4> corner{k, k + 1, k + columns_, k + columns_ + 1};
  double most = kInfinity;
  std::array<Vec2, 4> slope;
  Vec3 n = Vec3::Zero();
  bool open = false;
  for (std::size_t c = 0; c < 4; ++c) {
    const std::size_t at = corner[c];
    if (std::isnan(lattice_.z[at])) return false;
    open = open || lattice_.left[at] > lattice_.z[at] + static_cast<double>(lattice_.most[at]);
    const Vec3 normal(static_cast<double>(lattice_.nx[at]), static_cast<double>(lattice_.ny[at]),
                      static_cast<double>(lattice_.nz[at]));
    most = std::min(most, static_cast<double>(lattice_.most[at]));
    slope[c] = normal.head<2>() / std::max(normal.z(), kLeastCosine);
    n += normal;
  }
  if (!open && !cells_[k].open) return true;
  // The surface lies under the plane through three corners by no more than where it turns at once
  // from one corner's slope to another's.
  double turn = 0;
  for (std::size_t c = 1; c < 4; ++c) {
    for (std::size_t d = 0; d < c; ++d) turn = std::max(turn, (slope[c] - slope[d]).squaredNorm());
  }
  most -= std::sqrt(turn * (dx_ * dx_ + dy_ * dy_)) / 4;
  const double R = cutter_.radius();
  n.normalize();
  const MoveBins::Nearest near =
      bins.nearest(tip_of(offset_->cutter(), {{x(i) + dx_ / 2, y(j) + dy_ / 2, 0}, n}).head<2>());
  for (int m = 0; m < near.count; ++m) {
    std::array<double, 4> left;
    bool all = true;
    for (std::size_t c = 0; c < 4 && all; ++c) {
      const double rho2 =
          (near.tip[m].head<2>() - beyond_lattice(i + c % 2, j + c / 2)).squaredNorm();
      left[c] = near.tip[m].z() + cutter_.height(std::sqrt(rho2));
      all = rho2 <= R * R && left[c] <= lattice_.z[corner[c]] + most;
    }
    if (!all) continue;
    // Those of the row behind may be another thread's.
    const std::size_t own = (j + 1) % kTile == 0 ? 2 : 4;
    for (std::size_t c = 0; c < own; ++c) {
      lattice_.left[corner[c]] = std::min(lattice_.left[corner[c]], left[c]);
    }
    return true;
  }
  return false;
}

double LeftOver::cut_tile(OpenTile& tile, const PassedMove& move) {
  const double R = cutter_.radius();
  double highest = -kInfinity;
  for (OpenPart& part : tile.parts) {
    if (part.begin == part.end) continue;
    const auto lower = [&] {
      if (move.low >= part.top) return;
      const double gap = move.gap(part.box);
      if (gap > R || move.low_near(part.box, R) + cutter_.height(gap) >= part.top) return;
      part.top = -kInfinity;
      for (std::size_t k = part.begin; k < part.end;) {
        OpenPoint& point = tile.points[k];
        move.lower(cutter_, point.at, point.left);
        if (point.left > point.done) {
          part.top = std::max(part.top, point.left);
          ++k;
        } else {
          *point.kept = point.left;
          point = tile.points[--part.end];
        }
      }
    };
    lower();
    highest = std::max(highest, part.top);
  }
  return highest;
}

double LeftOver::stays(const Points& points, std::size_t k, const Vec2& at) const {
  if (points.left[k] == kInfinity) return kInfinity;  // never cut, whatever the normal
  const double above = points.left[k] - points.z[k], nz = static_cast<double>(points.nz[k]);
  const double on_plane = above * nz;
  const double enough = call(points, k);
  if (!(above > enough) || on_plane > enough) return on_plane;
  // Where the surface ends or bends away the plane of the point goes on without it.
  const Vec3 n(static_cast<double>(points.nx[k]), static_cast<double>(points.ny[k]), nz);
  return distance({at.x(), at.y(), points.left[k]}, at - on_plane * n.head<2>(), above, enough);
}

double LeftOver::distance(const Vec3& top, const Vec2& foot, double above, double enough) const {
  double best = above;
  Vec2 nearest = top.head<2>();
  const auto look = [&](const Vec2& at) {
    const Vec3 p = offset_->from_frame({at.x(), at.y(), 0});
    const std::optional<CcDatum> cc = surface_->at(p.x(), p.y());
    if (!cc) return;
    const double side = (at - top.head<2>()).norm(), down = std::max(0.0, top.z() - cc->z);
    const double there = std::sqrt(side * side + down * down);
    if (there < best) {
      best = there;
      nearest = at;
    }
  };
  look(foot);
  constexpr double kFinest = 1.0 / 32;  // of the distance
  for (double step = best / 2; best > enough && step > kFinest * best; step /= 2) {
    const Vec2 from = nearest;
    for (int way = 0; way < 8; ++way) {
      const double d = way % 2 == 0 ? step : step * std::numbers::sqrt2 / 2;
      const Vec2 to((way + 1) % 8 < 3    ? d
                    : way > 2 && way < 6 ? -d
                                         : 0,
                    way > 0 && way < 4 ? d
                    : way > 4          ? -d
                                       : 0);
      look(from + to);
    }
  }
  return best;
}

void LeftOver::add_to_runs(Vec3 at, bool goes_on, std::vector<std::vector<Vec3>>& runs) {
  const double far = cutter_.radius() / 2 + 4 * step_;
  if (at.z() == kNoContact) at.z() = drop_->at(at.x(), at.y());
  if (!goes_on || (at - runs.back().back()).norm() > far) runs.emplace_back();
  runs.back().push_back(at);
}

void LeftOver::add_row_runs(std::size_t j, std::vector<std::vector<Vec3>>& runs) {
  std::size_t last = columns_;
  for (std::size_t i = 0; i < columns_; ++i) {
    const std::size_t k = j * columns_ + i;
    if (lattice_.fit[k] == Fit::kCut) continue;
    const Place found = place(lattice_, k, at_lattice(k), limits_.call);
    if (!(found.height > 0)) continue;
    if (lattice_.fit[k] == Fit::kYes) lattice_.fit[k] = Fit::kCut;
    add_to_runs(found.tip, last < columns_ && i <= last + kGap, runs);
    last = i;
  }
}

void LeftOver::add_cell_run(Between& points, std::size_t i, std::size_t j, std::size_t& last,
                            std::vector<std::vector<Vec3>>& runs) {
  const std::size_t k = points.begin[j % kTile * kTile + i % kTile];
  if (k == kNone) return;
  const Cell& cell = cells_[j * columns_ + i];
  std::size_t worst = k;
  const double enough = call(points, k);
  Place most{enough, Vec3::Zero()};
  for (std::size_t p = k; p < k + cell.points(); ++p) {
    if (points.fit[p] == Fit::kCut) continue;
    const Place here = place(points, p, {points.x[p], points.y[p]}, most.height);
    if (!(here.height > most.height)) continue;
    most = here;
    worst = p;
  }
  if (!(most.height > enough)) return;
  if (points.fit[worst] == Fit::kYes) points.fit[worst] = Fit::kCut;
  add_to_runs(most.tip, last < columns_ && i <= last + kGap, runs);
  last = i;
}

void LeftOver::add_band_runs(std::size_t j, std::vector<std::vector<Vec3>>& runs) {
  std::size_t last = columns_;
  for (std::size_t i = 0; i + 1 < columns_; ++i) {
    Between& points = between_[tile_of(i, j)];
    if (!points.begin.empty()) add_cell_run(points, i, j, last, runs);
  }
}

std::size_t LeftOver::nearest_point(const Vec2& at) const {
  const auto nearest = [](double v, std::size_t count) {
    return static_cast<std::size_t>(std::clamp(v + 0.5, 0.0, static_cast<double>(count - 1)));
  };
  return nearest((at.y() - y0_) * per_y_, rows_) * columns_ +
         nearest((at.x() - x0_) * per_x_, columns_);
}

double LeftOver::stands_near(const Vec2& at) const {
  const std::size_t k = nearest_point(at);
  const double above = lattice_.left[k] - lattice_.z[k];
  return above < kInfinity ? above * static_cast<double>(lattice_.nz[k]) : 0;  // holes, too
}

std::vector<std::vector<Vec3>> LeftOver::open_runs(std::size_t stride) {
  flush();
  add_between();
  const std::size_t taken = (rows_ + stride - 1) / stride;
  std::vector<std::vector<std::vector<Vec3>>> found(taken);
  parallel_blocks(taken, 1, threads_, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t r = begin; r < end; ++r) {
      add_row_runs(r * stride, found[r]);
      if (r * stride + 1 < rows_) add_band_runs(r * stride, found[r]);
    }
  });
  std::vector<std::vector<Vec3>> all;
  for (auto& runs : found) {
    std::move(runs.begin(), runs.end(), std::back_inserter(all));
  }
  return all;
}

double LeftOver::highest_out_of_reach() {
  flush();
  double highest = 0;
  for (std::size_t k = 0; k < lattice_.z.size(); ++k) {
    const double above = lattice_.left[k] - lattice_.z[k];
    if (!(above > limits_.limit) || above <= highest || fits(lattice_, k, at_lattice(k))) continue;
    const Vec2 at = at_lattice(k);
    // Where nothing was cut, from right above.
    const double stands = above < kInfinity
                              ? above
                              : drop_->at(at.x(), at.y()) + offset_->cutter().radius() -
                                    cutter_.radius() - lattice_.z[k];
    highest = std::max(highest, stands);
  }
  return highest;
}

LeftOver::Rest LeftOver::rest() {
  flush();
  add_between();
  const std::size_t blocks = (rows_ + kTile - 1) / kTile;
  std::vector<Rest> of(blocks);
  parallel_blocks(blocks, 1, threads_, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t block = begin; block < end; ++block) {
      Rest& sum = of[block];
      const auto add = [&](Points& points, std::size_t k, const Vec2& at, double area) {
        const double least = limits_.limit - static_cast<double>(points.slack[k]);
        const Place here = place(points, k, at, least);
        if (!(here.height > least)) return;
        const bool on_it = fits(points, k, at);
        (here.height > limits_.limit ? sum.area : sum.unsettled) +=
            on_it ? area : static_cast<double>(points.beside_step) * area;
        if (!(here.height > limits_.limit)) return;
        sum.height = std::max(sum.height, here.height);
      };
      for (std::size_t k = block * kTile * columns_;
           k < std::min(block * kTile + kTile, rows_) * columns_; ++k) {
        add(lattice_, k, at_lattice(k), own_area(k));
      }
      for (std::size_t t = 0; t < tiles_; ++t) {
        Between& tile = between_[block * tiles_ + t];
        for (std::size_t k = 0; k < tile.z.size(); ++k) {
          add(tile, k, {tile.x[k], tile.y[k]}, static_cast<double>(tile.area[k]));
        }
      }
    }
  });
  Rest sum;
  for (const Rest& row : of) {
    sum.area += row.area;
    sum.unsettled += row.unsettled;
    sum.height = std::max(sum.height, row.height);
  }
  return sum;
}

}  // namespace diesink
