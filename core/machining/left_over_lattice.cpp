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
// Of the lattice's step, half the chord that the rim cuts off a line; of what may stay, a tip's way
// inward from where its rim would touch the end of the surface only.
constexpr double kRimChord = 0.75, kRimPart = 0.05;

// Normals between these cosines are of slopes, where what stands straight up is more than what
// stays. Rounding of a distance, relative.
constexpr double kLeastCosine = 0.05, kSlopeCosine = 0.9, kHair = 1e-6;

// Points further apart than they should be call so much of `call` earlier, at most.
constexpr double kMostSlack = 0.5;

// Of the points between the lattice's, one in so many is tried from beside.
constexpr std::size_t kBesideStep = 3;

// Corners of a cell at the ends of its sides.
constexpr std::array<std::array<std::size_t, 2>, 4> kSides{{{0, 1}, {0, 2}, {1, 3}, {2, 3}}};
// The place on a side where the surface ends, to a millionth of the side.
constexpr int kEndHalves = 20;

double square(double v) { return v * v; }

}  // namespace

void LeftOver::Points::resize(std::size_t count) {
  z.resize(count, std::numeric_limits<double>::quiet_NaN());
  left.resize(count, -kInfinity);
  nx.resize(count, 0);
  ny.resize(count, 0);
  nz.resize(count, 1);
  most.resize(count, 0);
  fit.resize(count, Fit::kUnknown);
  slack.resize(count, 0);
}

void LeftOver::take(Points& points, std::size_t k, const Vec2& at) const {
  const Vec3 p = offset_->from_frame({at.x(), at.y(), 0});
  if (const auto cc = surface_->at(p.x(), p.y())) take(points, k, at, cc->z, cc->n);
}

void LeftOver::take(Points& points, std::size_t k, const Vec2& at, double z,
                    const Vec3& normal) const {
  const Vec3 n = offset_->to_frame(normal);
  points.z[k] = z;
  points.left[k] = kInfinity;
  points.nx[k] = static_cast<float>(n.x());
  points.ny[k] = static_cast<float>(n.y());
  points.nz[k] = static_cast<float>(n.z());
  const double enough = call(points, k);
  double most = enough;
  if (n.z() > kLeastCosine && n.z() < kSlopeCosine) {
    // On a slope more may stand straight up where the surface comes as near to that as its plane
    // does. Then it is near to all that is lower, too: what is under the surface is the part.
    const Vec2 foot = at - enough * n.head<2>();
    const Vec3 q = offset_->from_frame({foot.x(), foot.y(), 0});
    const double high = enough / n.z();
    const std::optional<CcDatum> there = surface_->at(q.x(), q.y());
    if (there && (foot - at).squaredNorm() + square(std::max(0.0, z + high - there->z)) <=
                     square(enough * (1 + kHair))) {
      most = high;
    }
  }
  points.most[k] = static_cast<float>(most);
}

void LeftOver::take_row(std::size_t j, std::span<const PlanBox> places) {
  const Span inside = domain_.pass(y(j));
  std::vector<bool> asked(columns_, places.empty());
  for (const PlanBox& place : places) {
    if (y(j) < place.y0 || y(j) > place.y1) continue;
    for (std::size_t i = 0; i < columns_; ++i) {
      if (x(i) >= place.x0 && x(i) <= place.x1) asked[i] = true;
    }
  }
  const auto wanted = [&](std::size_t i) {
    return asked[i] && x(i) >= inside.x0 - hair_ && x(i) <= inside.x1 + hair_;
  };
  if (places.empty() && offset_->from_frame(Vec3::UnitX()) == Vec3::UnitX()) {
    // Rows at once cost a part of points one by one.
    std::vector<double> xs, z(columns_), nx(columns_), ny(columns_), nz(columns_);
    std::vector<Label> label(columns_);
    for (std::size_t i = 0; i < columns_; ++i) xs.push_back(x(i));
    surface_->row(y(j), xs, {z.data(), nx.data(), ny.data(), nz.data(), label.data()});
    for (std::size_t i = 0; i < columns_; ++i) {
      if (label[i] == kNoLabel || !wanted(i)) continue;
      take(lattice_, j * columns_ + i, {x(i), y(j)}, z[i], {nx[i], ny[i], nz[i]});
    }
    return;
  }
  for (std::size_t i = 0; i < columns_; ++i) {
    if (wanted(i)) take(lattice_, j * columns_ + i, {x(i), y(j)});
  }
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
      threads_(threads),
      everywhere_(places.empty()) {
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
  per_x_ = 1 / dx_;
  per_y_ = 1 / dy_;
  lattice_.resize(columns_ * rows_);
  const double R = cutter.radius();
  reach_ = {x0_ - R, x(columns_ - 1) + R, y0_ - R, y(rows_ - 1) + R};
  hair_ = 1e-9 * R;
  const double inward = kRimPart * limits.limit;
  rim_ = inward / R;
  beside_run_ = inward - std::min(kRimChord * kRimChord * step_ * step_ / (2 * R), inward / 2);
  parallel_blocks(rows_, kRowsABlock, threads_, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t j = begin; j < end; ++j) take_row(j, places);
  });
  divide_cells();
}

LeftOver::Cell LeftOver::cell_of(std::size_t i, std::size_t j) const {
  const std::size_t k = j * columns_ + i;
  const std::array<std::size_t, 4> corner{k, k + 1, k + columns_, k + columns_ + 1};
  double gx = 0, gy = 0, low = kInfinity, high = -kInfinity, least = 1;
  std::array<Vec3, 4> n;
  const auto none = [&](std::size_t c) { return std::isnan(lattice_.z[c]); };
  if (std::any_of(corner.begin(), corner.end(), none)) {
    Cell cell;
    if (!everywhere_) return cell;
    for (const auto& [a, b] : kSides) {
      cell.nx = static_cast<std::uint8_t>(cell.nx + (none(corner[a]) != none(corner[b]) ? 1 : 0));
    }
    if (cell.nx > 1) --cell.nx;
    cell.smooth = false;
    cell.open = cell.border = cell.nx > 1;
    return cell;
  }
  for (std::size_t c = 0; c < 4; ++c) {
    const std::size_t at = corner[c];
    n[c] = Vec3(static_cast<double>(lattice_.nx[at]), static_cast<double>(lattice_.ny[at]),
                static_cast<double>(lattice_.nz[at]));
    gx = std::max(gx, std::fabs(n[c].x()) / std::max(n[c].z(), 1e-3));
    gy = std::max(gy, std::fabs(n[c].y()) / std::max(n[c].z(), 1e-3));
    low = std::min(low, lattice_.z[at]);
    high = std::max(high, lattice_.z[at]);
    for (std::size_t d = 0; d < c; ++d) least = std::min(least, n[c].dot(n[d]));
  }
  const bool edge = least < kEdgeCosine || high - low > (gx + gy + kWallHeight) * step_;
  const double margin = limits_.limit - limits_.call;
  Cell cell;
  cell.smooth = !edge;
  const auto parts = [&](double slope) {
    const double along = std::min(std::sqrt(1 + slope * slope), 1e3);
    // What a sharp corner leaves on a slope grows downhill as steeply as the slope, and ends at
    // once: the highest of it may be a whole distance of points away from the next.
    const double grows = cutter_.corner() < limits_.limit ? step_ * (slope / along) : 0;
    const int count =
        static_cast<int>(std::max(std::round(along), std::ceil(grows / margin - kHair)));
    const int taken = std::min(std::max(count, edge ? kEdgeParts : 1), most_parts_);
    const double more = grows / taken - margin;
    if (more > 0) {
      cell.slack = static_cast<float>(
          std::max(static_cast<double>(cell.slack), std::min(more, kMostSlack * limits_.call)));
    }
    return static_cast<std::uint8_t>(taken);
  };
  cell.nx = parts(gx);
  cell.ny = parts(gy);
  cell.open = cell.points() > 1;
  return cell;
}

void LeftOver::divide_cells() {
  tiles_ = (columns_ + kTile - 1) / kTile;
  const std::size_t tiles = tiles_ * ((rows_ + kTile - 1) / kTile);
  highest_.assign(tiles, kInfinity);
  between_.resize(tiles);
  for (Between& tile : between_) tile.beside_step = kBesideStep;
  cells_.resize(lattice_.z.size());
  std::vector<std::size_t> points(rows_);
  for (;; most_parts_ = most_parts_ * 3 / 4) {
    parallel_blocks(rows_ - 1, kRowsABlock, threads_, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t j = begin; j < end; ++j) {
        points[j] = 0;
        for (std::size_t i = 0; i + 1 < columns_; ++i) {
          const Cell cell = cell_of(i, j);
          cells_[j * columns_ + i] = cell;
          if (cell.open) points[j] += cell.points();
        }
      }
    });
    std::size_t all = 0;
    for (const std::size_t count : points) all += count;
    if (static_cast<double>(all) <= kMostPoints || most_parts_ == 1) break;
  }
}

std::vector<Vec2> LeftOver::ends_of(std::size_t i, std::size_t j) const {
  const std::size_t k = j * columns_ + i;
  const std::array<std::size_t, 4> corner{k, k + 1, k + columns_, k + columns_ + 1};
  std::vector<Vec2> out;
  for (const auto& [a, b] : kSides) {
    const bool in_a = !std::isnan(lattice_.z[corner[a]]);
    if (in_a == !std::isnan(lattice_.z[corner[b]])) continue;
    Vec2 in = at_lattice(corner[in_a ? a : b]), off = at_lattice(corner[in_a ? b : a]);
    for (int halves = 0; halves < kEndHalves; ++halves) {
      const Vec2 middle = (in + off) / 2;
      const Vec3 p = offset_->from_frame({middle.x(), middle.y(), 0});
      (in_domain(middle) && surface_->at(p.x(), p.y()) ? in : off) = middle;
    }
    out.push_back(in);
  }
  return out;
}

std::vector<Vec2> LeftOver::beyond_ends(std::size_t i, std::size_t j, const Between& points) const {
  const std::size_t k = j * columns_ + i;
  const std::array<std::size_t, 4> corner{k, k + 1, k + columns_, k + columns_ + 1};
  std::size_t p = points.begin[j % kTile * kTile + i % kTile];
  std::vector<Vec2> out;
  for (const auto& [a, b] : kSides) {
    const bool in_a = !std::isnan(lattice_.z[corner[a]]);
    if (in_a == !std::isnan(lattice_.z[corner[b]])) continue;
    const Vec2 off = at_lattice(corner[in_a ? b : a]) - at_lattice(corner[in_a ? a : b]);
    out.push_back(Vec2(points.x[p], points.y[p]) + beside_run() * off.normalized());
    ++p;
  }
  return out;
}

void LeftOver::add_between(std::size_t i, std::size_t j) {
  Cell& cell = cells_[j * columns_ + i];
  Between& tile = between_[tile_of(i, j)];
  cell.open = false;
  if (tile.begin.empty()) tile.begin.assign(kTile * kTile, kNone);
  std::size_t k = tile.z.size();
  tile.begin[j % kTile * kTile + i % kTile] = static_cast<std::uint32_t>(k);
  const int nx = cell.nx, ny = cell.ny;
  const std::size_t count = k + cell.points();
  tile.resize(count);
  tile.x.resize(count);
  tile.y.resize(count);
  // Of a cell where the surface ends, half.
  tile.area.resize(count, static_cast<float>(dx_ * dy_ / (nx * ny) / (cell.border ? 2 : 1)));
  std::fill(tile.slack.begin() + static_cast<std::ptrdiff_t>(k), tile.slack.end(), cell.slack);
  if (cell.border) {
    for (const Vec2& at : ends_of(i, j)) {
      tile.x[k] = at.x();
      tile.y[k] = at.y();
      take(tile, k++, at);
    }
    return;
  }
  for (int a = 0; a < nx; ++a) {
    for (int b = 0; b < ny; ++b, ++k) {
      tile.x[k] = x(i) + (a + 0.5) / nx * dx_;
      tile.y[k] = y(j) + (b + 0.5) / ny * dy_;
      take(tile, k, {tile.x[k], tile.y[k]});
    }
  }
}

void LeftOver::add_between() {
  const std::size_t blocks = (rows_ + kTile - 1) / kTile;
  parallel_blocks(blocks, 1, threads_, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t k = begin * kTile * columns_; k < std::min(end * kTile, rows_) * columns_;
         ++k) {
      if (cells_[k].open) add_between(k % columns_, k / columns_);
    }
  });
}

// What is not of points between its own.
double LeftOver::own_area(std::size_t k) const {
  const std::size_t i = k % columns_, j = k / columns_;
  int quarters = 0;
  for (const std::size_t a : {i - 1, i}) {
    for (const std::size_t b : {j - 1, j}) {
      const bool divided =
          a < columns_ - 1 && b < rows_ - 1 && cells_[b * columns_ + a].points() > 1;
      quarters += divided ? 0 : 1;
    }
  }
  return 0.25 * quarters * dx_ * dy_;
}

}  // namespace diesink
