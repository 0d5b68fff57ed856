// SPDX-License-Identifier: Apache-2.0
#include "core/machining/left_over.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/machining/interference.h"
#include "core/machining/passed_move.h"
#include "core/parallel.h"

namespace diesink {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kMovesATime = 8192;
constexpr double kLeastCosine = 0.05;  // of normals, where a height is divided by it
// A run goes on over so many columns.
constexpr std::size_t kGap = 4;
// Of the limit, what the mesh may lie beside the surface where the lattice knows that.
constexpr double kMeshPart = 0.15;
// Of the points between the lattice's, one in so many is tried from beside.
constexpr std::size_t kBesideStep = 3;
// Ways from a point in which a cutter is tried beside it.
constexpr std::size_t kHeadings = 24;

// How deep a point lies in the cutter, at the distance rho from the axis and so high over the tip;
// negative outside.
double depth_in(const CutterShape& cutter, double rho, double height) {
  const double side = rho - cutter.flat(), under = cutter.corner() - height;
  if (side <= 0 || under <= 0) return cutter.corner() - std::max(side, under);
  return cutter.corner() - std::sqrt(side * side + under * under);
}

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
      cut_block(block, near);
    }
  });
}

void LeftOver::cut_block(std::size_t block, std::span<const PassedMove> moves) {
  const double R = cutter_.radius();
  const std::size_t j0 = block * kTile, j1 = std::min(j0 + kTile, rows_ - 1);
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
      cut_tile(block, t, move);
      top = highest(block, t);
    }
  }
}

void LeftOver::cut_tile(std::size_t block, std::size_t tile, const PassedMove& move) {
  const double R = cutter_.radius();
  const std::size_t i0 = tile * kTile, i1 = std::min(i0 + kTile, columns_);
  for (std::size_t j = block * kTile, end = std::min(j + kTile, rows_); j < end; ++j) {
    if (y(j) >= move.y0 - R && y(j) <= move.y1 + R) {
      for (std::size_t i = i0; i < i1; ++i) {
        move.lower(cutter_, {x(i), y(j)}, lattice_.left[j * columns_ + i]);
      }
    }
    if (j + 1 == rows_) continue;
    const auto [first, last] = between_of(j, tile);
    for (std::size_t k = first; k < last; ++k) {
      move.lower(cutter_, at_between(k), between_.left[k]);
    }
  }
}

double LeftOver::highest(std::size_t block, std::size_t tile) const {
  double most = -kInfinity;
  const std::size_t i0 = tile * kTile, i1 = std::min(i0 + kTile, columns_);
  for (std::size_t j = block * kTile, end = std::min(j + kTile, rows_); j < end; ++j) {
    for (std::size_t i = i0; i < i1; ++i) most = std::max(most, lattice_.left[j * columns_ + i]);
    if (j + 1 == rows_) continue;
    const auto [first, last] = between_of(j, tile);
    for (std::size_t k = first; k < last; ++k) most = std::max(most, between_.left[k]);
  }
  return most;
}

double LeftOver::stays(const Points& points, std::size_t k, const Vec2& at) const {
  if (std::isnan(points.z[k])) return 0;
  if (points.left[k] == kInfinity) return kInfinity;  // never cut, whatever the normal
  const double above = points.left[k] - points.z[k], nz = static_cast<double>(points.nz[k]);
  const double on_plane = above * nz;
  if (!(above > limits_.call) || on_plane > limits_.call) return on_plane;
  // Where the surface ends or bends away the plane of the point goes on without it.
  const Vec3 n(static_cast<double>(points.nx[k]), static_cast<double>(points.ny[k]), nz);
  return distance({at.x(), at.y(), points.left[k]}, at - on_plane * n.head<2>(), above);
}

double LeftOver::distance(const Vec3& top, const Vec2& foot, double above) const {
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
  for (double step = best / 2; best > limits_.call && step > kFinest * best; step /= 2) {
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

Vec3 LeftOver::tip(const Points& points, std::size_t k, const Vec2& at) const {
  const Vec3 n(static_cast<double>(points.nx[k]), static_cast<double>(points.ny[k]),
               static_cast<double>(points.nz[k]));
  Vec3 tip = tip_of(offset_->cutter(), {{at.x(), at.y(), points.z[k]}, n});
  // At the end of the surface, whose point would lie on the cutter's very rim: so far within it
  // that neighbours on a line along the end are met as well.
  tip.head<2>() += rim_ * (at - tip.head<2>());
  return tip;
}

bool LeftOver::fits(Points& points, std::size_t k, const Vec2& over) {
  if (points.fit[k] == Fit::kUnknown) {
    const Vec3 at = tip(points, k, over);
    const Span inside = domain_.pass(at.y());
    // Up the axis: along the normal a steep surface leaves less than that.
    const double nz = std::max(static_cast<double>(points.nz[k]), kLeastCosine);
    const double allowed = at.z() + limits_.fits / nz;
    bool yes = at.y() >= domain_.low() && at.y() <= domain_.high() && at.x() >= inside.x0 - hair_ &&
               at.x() <= inside.x1 + hair_;
    if (yes) {
      // Beside a wall over a hole the cutter may pass the mesh by and meet nothing.
      const double z = drop_->at(at.x(), at.y(), std::nextafter(allowed, kInfinity));
      yes = z != kNoContact && z <= allowed;
    }
    points.fit[k] = yes ? Fit::kYes : Fit::kNo;
  }
  return points.fit[k] == Fit::kYes || points.fit[k] == Fit::kCut;
}

bool LeftOver::may_hold(const Vec2& at, double rho, double top, double least) const {
  const CutterShape& cutter = offset_->cutter();
  const double grown = cutter.corner() - cutter_.corner();
  const double hair = kMeshPart * limits_.limit;
  const auto nearest = [](double v, std::size_t count) {
    return static_cast<std::size_t>(std::clamp(v + 0.5, 0.0, static_cast<double>(count - 1)));
  };
  const auto look = [&](const Vec2& p, std::size_t& k) {
    const std::size_t i = nearest((p.x() - x0_) / dx_, columns_);
    const std::size_t j = nearest((p.y() - y0_) / dy_, rows_);
    k = j * columns_ + i;
    const double off2 = (Vec2(x(i), y(j)) - at).squaredNorm();
    if (std::isnan(lattice_.z[k]) || off2 > cutter.radius() * cutter.radius()) return true;
    const double tip = lattice_.z[k] - cutter.height(std::sqrt(off2)) - hair;
    return depth_in(cutter_, rho, top - tip - grown) > least;
  };
  std::size_t k = 0;
  if (!look(at, k)) return false;
  // Where the cutter would touch the surface's plane here.
  const Vec2 n(static_cast<double>(lattice_.nx[k]), static_cast<double>(lattice_.ny[k]));
  const double flat = n.norm();
  return !(flat > 0) || look(at - (cutter.corner() + cutter.flat() / flat) * n, k);
}

bool LeftOver::in_domain(const Vec2& at) const {
  const std::array<Vec2, 4>& c = domain_.corners();
  for (std::size_t k = 0; k < 4; ++k) {
    const Vec2 side = c[(k + 1) % 4] - c[k], off = at - c[k];
    const double left = side.x() * off.y() - side.y() * off.x();
    if (left < 0 && left < -hair_ * side.norm()) return false;
  }
  return true;
}

bool LeftOver::falls_off(const Points& points, std::size_t k, const Vec2& over) const {
  const double down = points.left[k] - 2 * std::max(limits_.limit, step_);
  const auto nearest = [](double at, double from, double step, std::size_t count) {
    return static_cast<std::size_t>(
        std::clamp(std::round((at - from) / step), 0.0, static_cast<double>(count - 1)));
  };
  const std::size_t i = nearest(over.x(), x0_, dx_, columns_);
  const std::size_t j = nearest(over.y(), y0_, dy_, rows_);
  for (std::size_t b = j - std::min<std::size_t>(j, 1); b <= std::min(j + 1, rows_ - 1); ++b) {
    for (std::size_t a = i - std::min<std::size_t>(i, 1); a <= std::min(i + 1, columns_ - 1); ++a) {
      const std::size_t at = b * columns_ + a;
      if (lattice_.left[at] < down && !std::isnan(lattice_.z[at])) return true;
    }
  }
  return false;
}

LeftOver::Place LeftOver::beside(Points& points, std::size_t k, const Vec2& over,
                                 double least) const {
  Place best{least, Vec3::Zero()};
  const double R = cutter_.radius();
  // All that stands over the point, deep in a slot as well; where nothing was cut, a radius of it.
  const double top = points.left[k] < kInfinity ? points.left[k] : points.z[k] + R;
  const double grown = offset_->cutter().corner() - cutter_.corner();
  static const std::array<Vec2, kHeadings> headings = [] {
    std::array<Vec2, kHeadings> out;
    for (std::size_t h = 0; h < kHeadings; ++h) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(h) / kHeadings;
      out[h] = Vec2(std::cos(angle), std::sin(angle));
    }
    return out;
  }();
  bool found = false;
  // Deep in the cutter first: what is cut far from its rim needs the fewest runs.
  for (double depth = R / 2; !found; depth = std::max(depth / 2, limits_.call)) {
    const double rho = R - std::max(depth, limits_.call);
    for (std::size_t heading = 0; heading < kHeadings; ++heading) {
      const Vec2 at = over + rho * headings[heading];
      if (!in_domain(at)) continue;
      // Most often the part itself keeps a cutter from it.
      if (!may_hold(at, rho, top, best.height)) continue;
      const double z = drop_->at(at.x(), at.y(), top - best.height);
      if (z == kNoContact) continue;
      const double held = depth_in(cutter_, rho, top - z - grown);
      if (!(held > best.height)) continue;
      best = {held, Vec3(at.x(), at.y(), z)};
      found = true;
    }
    if (!(depth > limits_.call)) break;
  }
  // What no cutter held deep enough is held no deeper once there is less of it.
  if (!found && least <= limits_.call) points.fit[k] = Fit::kNowhere;
  return found ? best : Place{0, Vec3::Zero()};
}

LeftOver::Place LeftOver::place(Points& points, std::size_t k, const Vec2& over, double least) {
  const Place none{0, Vec3::Zero()};
  // The quick answers first: what stays is no more than what stands straight up, and the distance
  // to the surface beside walls takes longest.
  if (std::isnan(points.z[k]) || !(points.left[k] - points.z[k] > least)) return none;
  if (!fits(points, k, over)) {
    const bool tried = &points != &between_ || k % kBesideStep == 0;
    if (!tried || points.fit[k] == Fit::kNowhere || !falls_off(points, k, over)) return none;
    return stays(points, k, over) > least ? beside(points, k, over, least) : none;
  }
  const double height = stays(points, k, over);
  if (!(height > least)) return none;
  Vec3 at = tip(points, k, over);
  at.z() = kNoContact;  // lowered when it is used
  return {height, at};
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

void LeftOver::add_band_runs(std::size_t j, std::vector<std::vector<Vec3>>& runs) {
  const double none = -kInfinity;
  double last = none;
  for (std::size_t k = between_.begin[j]; k < between_.begin[j + 1];) {
    const double end = std::max(x0_ + (std::floor((between_.x[k] - x0_) / dx_) + 1) * dx_,
                                std::nextafter(between_.x[k], kInfinity));
    std::size_t worst = k;
    Place most{limits_.call, Vec3::Zero()};
    for (; k < between_.begin[j + 1] && between_.x[k] < end; ++k) {
      if (between_.fit[k] == Fit::kCut) continue;
      const Place here = place(between_, k, at_between(k), most.height);
      if (!(here.height > most.height)) continue;
      most = here;
      worst = k;
    }
    if (!(most.height > limits_.call)) continue;
    if (between_.fit[worst] == Fit::kYes) between_.fit[worst] = Fit::kCut;
    add_to_runs(most.tip, between_.x[worst] <= last + static_cast<double>(kGap) * dx_, runs);
    last = between_.x[worst];
  }
}

std::vector<std::vector<Vec3>> LeftOver::open_runs(std::size_t stride) {
  flush();
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

LeftOver::Rest LeftOver::rest() {
  flush();
  std::vector<Rest> of(rows_);
  parallel_blocks(rows_, kRowsABlock, threads_, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t j = begin; j < end; ++j) {
      const auto add = [&](Points& points, std::size_t k, const Vec2& at, double area) {
        const Place here = place(points, k, at, limits_.limit);
        if (!(here.height > limits_.limit)) return;
        const bool on_it = fits(points, k, at);
        of[j].area += &points == &between_ && !on_it ? kBesideStep * area : area;
        of[j].height = std::max(of[j].height, here.height);
      };
      for (std::size_t k = j * columns_; k < (j + 1) * columns_; ++k) {
        add(lattice_, k, at_lattice(k), own_area(k));
      }
      for (std::size_t k = between_.begin[j]; j + 1 < rows_ && k < between_.begin[j + 1]; ++k) {
        add(between_, k, at_between(k), static_cast<double>(between_.area[k]));
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
