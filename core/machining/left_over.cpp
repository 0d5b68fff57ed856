// SPDX-License-Identifier: Apache-2.0
#include "core/machining/left_over.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/machining/interference.h"
#include "core/parallel.h"

namespace diesink {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kMostPoints = 2e6;
constexpr std::size_t kMovesATime = 8192;
constexpr std::size_t kRowsABlock = 16;
// Points to a side of a cell where an edge passes.
constexpr int kEdgeParts = 4;
// Normals of a cell's corners further apart than this, some 6 degrees, have an edge between them.
constexpr double kEdgeCosine = 0.995;
// Heights further apart than slopes explain, in spacings: there is a wall between.
constexpr double kWallHeight = 0.5;
constexpr double kLeastCosine = 0.05;  // of normals, where a height is divided by it
// A run goes on over so many columns.
constexpr std::size_t kGap = 4;
// Of the lattice's step, half the chord that the rim cuts off a line; of what may stay, the most
// that its way inward costs.
constexpr double kRimChord = 0.75, kRimPart = 0.05;
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

// Steps of the search below, what of the corner's radius, squared, is its rim, and the step, in
// radii, at which it ends: no height is off by more than 1e-5 of the radius then, by far fewer
// mostly.
constexpr int kMostSteps = 20;
constexpr double kNearRim = 0.01, kStill = 1e-5;

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
  // The height is convex along the move: Newton's method on its rise, kept between ends where that
  // falls and grows, from where the corner's circle has the move's slope. Near the cutter's rim the
  // rise bends too much for its steps: halves there.
  const double F = cutter.flat(), r = cutter.corner();
  const double touch = F + r * std::fabs(slope) / std::sqrt(1 + slope * slope);
  const double behind = std::sqrt(std::max(0.0, touch * touch - w2));
  double low = first, high = last;
  double s = std::clamp(slope > 0 ? u - behind : u + behind, first, last);
  for (int k = 0; k < kMostSteps; ++k) {
    const double off = s - u, rho = std::sqrt(w2 + off * off), beyond = rho - F;
    const double square = r * r - beyond * beyond;
    double rise = slope, next = (low + high) / 2;
    if (beyond > 0 && square > kNearRim * r * r) {
      const double depth = std::sqrt(square), steep = beyond / depth, way = off / rho;
      rise += steep * way;
      const double bend = r * r / (square * depth) * way * way + steep * w2 / (rho * rho * rho);
      (rise > 0 ? high : low) = s;
      next = s - rise / bend;
      if (!(next > low && next < high)) next = (low + high) / 2;
    } else {
      if (beyond > 0) rise += beyond / std::sqrt(std::max(square, 1e-300)) * off / rho;
      (rise > 0 ? high : low) = s;
      next = (low + high) / 2;
    }
    const double step = std::fabs(next - s);
    s = next;
    if (step < kStill * R) break;
  }
  return std::min({at(first), at(last), at(s)});
}

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

void LeftOver::cut(const Vec3& from, const Vec3& to) {
  if (std::max(from.x(), to.x()) < reach_.x0 || std::min(from.x(), to.x()) > reach_.x1 ||
      std::max(from.y(), to.y()) < reach_.y0 || std::min(from.y(), to.y()) > reach_.y1) {
    return;
  }
  waiting_.push_back({from, to});
  if (waiting_.size() >= kMovesATime) flush();
}

// A move as points beside it see it.
struct LeftOver::PassedMove {
  explicit PassedMove(const Move& move)
      : from(move.from.head<2>()), d((move.to - move.from).head<2>()), length(d.norm()) {
    low = std::min(move.from.z(), move.to.z());
    if (length > 0) along = d / length;
    if (length > 0) slope = (move.to.z() - move.from.z()) / length;
    z = length > 0 ? move.from.z() : low;
    y0 = std::min(move.from.y(), move.to.y());
    y1 = std::max(move.from.y(), move.to.y());
  }

  // Where points within `reach` of the strip y0 .. y1 may lie in x, less the reach itself.
  [[nodiscard]] std::array<double, 2> over(double low_y, double high_y) const {
    double t0 = 0, t1 = 1;
    if (d.y() != 0) {
      const double ta = (low_y - from.y()) / d.y(), tb = (high_y - from.y()) / d.y();
      t0 = std::clamp(std::min(ta, tb), 0.0, 1.0);
      t1 = std::clamp(std::max(ta, tb), 0.0, 1.0);
    }
    const double xa = from.x() + t0 * d.x(), xb = from.x() + t1 * d.x();
    return {std::min(xa, xb), std::max(xa, xb)};
  }

  // No point of the box is nearer in plan.
  [[nodiscard]] double gap(const PlanBox& box) const {
    const double x1 = from.x() + d.x();
    const double gap_x =
        std::max({0.0, box.x0 - std::max(from.x(), x1), std::min(from.x(), x1) - box.x1});
    const double gap_y = std::max({0.0, box.y0 - y1, y0 - box.y1});
    const double ox = (box.x0 + box.x1) / 2 - from.x(), oy = (box.y0 + box.y1) / 2 - from.y();
    const double square =
        std::fabs(oy * along.x() - ox * along.y()) -
        (std::fabs(along.y()) * (box.x1 - box.x0) + std::fabs(along.x()) * (box.y1 - box.y0)) / 2;
    return std::max(length > 0 ? square : 0, std::sqrt(gap_x * gap_x + gap_y * gap_y));
  }

  void lower(const CutterShape& cutter, const Vec2& p, double& left) const {
    if (low >= left) return;
    const double R = cutter.radius();
    const double ox = p.x() - from.x(), oy = p.y() - from.y();
    const double u = ox * along.x() + oy * along.y(), w = oy * along.x() - ox * along.y();
    const double off = u - std::clamp(u, 0.0, length), near2 = w * w + off * off;
    if (near2 > R * R || low + cutter.height(std::sqrt(near2)) >= left) return;
    left = std::min(left, lowest_over(cutter, z, slope, length, u, w * w));
  }

  Vec2 from, d, along{1, 0};
  double length, low = 0, slope = 0, z = 0, y0 = 0, y1 = 0;
};

void LeftOver::flush() {
  if (waiting_.empty()) return;
  const double R = cutter_.radius();
  std::vector<PassedMove> moves;
  moves.reserve(waiting_.size());
  for (const Move& move : waiting_) moves.emplace_back(move);
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

std::array<std::size_t, 2> LeftOver::between_of(std::size_t j, std::size_t tile) const {
  const std::size_t at = j * (tiles_ + 1) + tile;
  return {between_start_[at], between_start_[at + 1]};
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
