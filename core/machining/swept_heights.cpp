// SPDX-License-Identifier: Apache-2.0
#include "core/machining/swept_heights.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/base_surface.h"
#include "core/parallel.h"

namespace diesink {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kTile = 4;   // points a side
constexpr std::size_t kBlock = 8;  // tiles a side

// How far behind the axis, along a move of the slope `steep`, the corner of a bull nose is lowest
// over a line w beside it; at least `low`. There the corner's slope along the move is the move's:
// with rho the distance from the axis and d = rho - a, d b / (rho sqrt(r² - d²)) = steep, or
// d = r steep q, q² = rho² / (b² + steep² rho²). Over t = b² rho grows and is concave, q falls and
// is convex: Newton's method comes to the root from below, in every step.
double corner_back(const CutterShape& cutter, double steep, double w, double low) {
  const double r = cutter.corner(), a = cutter.flat(), R = cutter.radius();
  const double w2 = w * w, bend = 1 + steep * steep;
  const double touch = a + r * steep / std::sqrt(bend);  // the root for w = 0, else below it
  double t = std::max({0.0, low * low, touch * touch - w2});
  constexpr int kMostSteps = 60;
  constexpr double kRounding = 1e-14;  // of the radius, squared
  for (int k = 0; k < kMostSteps; ++k) {
    const double rho = std::sqrt(t + w2), below = bend * t + steep * steep * w2;
    if (!(rho > 0 && below > 0)) break;  // over the axis, where the end is flat
    const double q = rho / std::sqrt(below);
    const double missing = a + r * steep * q - rho;
    const double growth = 0.5 / rho + r * steep * w2 / (2 * q * below * below);
    const double step = missing / growth;
    if (!(step > kRounding * R * R)) break;
    t += step;
  }
  return std::sqrt(t);
}

// Where along the move, in plan length from its start, the cutter is lowest over a point that lies
// at u along and w across it, between `first` and `last`; the height along the move rises by
// `slope`. Found as the foot of the moving cutter's contour: the slope of its lower surface along
// the move equals the move's own.
double lowest_at(const CutterShape& cutter, double slope, double u, double w, double first,
                 double last) {
  const double r = cutter.corner(), a = cutter.flat();
  if (slope == 0) return std::clamp(u, first, last);
  // The cutter is lowest when it stands on the downhill side: `back` along the move.
  const double steep = std::fabs(slope), side = slope > 0 ? -1 : 1;
  double low = std::max(0.0, side > 0 ? first - u : u - last);
  double high = side > 0 ? last - u : u - first;
  if (high <= low) return std::clamp(u, first, last);
  double back;
  if (r <= 0) {
    back = high;  // the rim
  } else if (a <= 0) {
    back = steep / std::sqrt(1 + steep * steep) *
           std::sqrt(std::max(0.0, cutter.radius() * cutter.radius() - w * w));
  } else {
    back = std::min(high, corner_back(cutter, steep, w, low));
  }
  return std::clamp(u + side * back, first, last);
}

struct PlannedMove {
  SweepMove move;
  double dx = 0, dy = 0, length = 0, slope = 0;

  // Its part between two heights of the plan, in x.
  [[nodiscard]] std::array<double, 2> between(double y0, double y1) const {
    const Vec3 d = move.to - move.from;
    double t0 = 0, t1 = 1;
    if (d.y() != 0) {
      const double ta = (y0 - move.from.y()) / d.y(), tb = (y1 - move.from.y()) / d.y();
      t0 = std::clamp(std::min(ta, tb), 0.0, 1.0);
      t1 = std::clamp(std::max(ta, tb), 0.0, 1.0);
    }
    const double xa = move.from.x() + t0 * d.x(), xb = move.from.x() + t1 * d.x();
    return {std::min(xa, xb), std::max(xa, xb)};
  }
};

PlannedMove planned(const SweepMove& move) {
  PlannedMove out{move};
  const Vec3 d = move.to - move.from;
  out.length = d.head<2>().norm();
  if (out.length > 0) {
    out.dx = d.x() / out.length;
    out.dy = d.y() / out.length;
    out.slope = d.z() / out.length;
  }
  return out;
}

double height_over(const CutterShape& cutter, const PlannedMove& m, double x, double y) {
  const double ox = x - m.move.from.x(), oy = y - m.move.from.y(), R = cutter.radius();
  if (!(m.length > 0)) {
    const double rho2 = ox * ox + oy * oy;
    if (rho2 > R * R) return kInfinity;
    return std::min(m.move.from.z(), m.move.to.z()) + cutter.height(std::sqrt(rho2));
  }
  const double u = ox * m.dx + oy * m.dy, w = oy * m.dx - ox * m.dy;
  const double half2 = R * R - w * w;
  if (half2 < 0) return kInfinity;
  const double half = std::sqrt(half2);
  const double first = std::max(0.0, u - half), last = std::min(m.length, u + half);
  if (first > last) return kInfinity;
  const double s = lowest_at(cutter, m.slope, u, w, first, last);
  return m.move.from.z() + m.slope * s +
         cutter.height(std::min(R, std::sqrt(w * w + (s - u) * (s - u))));
}

// Nothing the move leaves over the box is lower; infinity where it does not come over it.
double lowest_in(const CutterShape& cutter, const PlannedMove& m, const PlanBox& box) {
  const auto& [from, to] = m.move;
  const double gap_x =
      std::max({0.0, box.x0 - std::max(from.x(), to.x()), std::min(from.x(), to.x()) - box.x1});
  const double gap_y =
      std::max({0.0, box.y0 - std::max(from.y(), to.y()), std::min(from.y(), to.y()) - box.y1});
  double gap2 = gap_x * gap_x + gap_y * gap_y;
  double low = std::min(from.z(), to.z());
  if (m.length > 0) {
    const double x = (box.x0 + box.x1) / 2 - from.x(), y = (box.y0 + box.y1) / 2 - from.y();
    const double width = (box.x1 - box.x0) / 2, depth = (box.y1 - box.y0) / 2;
    // Square to the move the box's nearest corner may be further off.
    const double square =
        std::fabs(y * m.dx - x * m.dy) - (std::fabs(m.dx) * depth + std::fabs(m.dy) * width);
    if (square > 0) gap2 = std::max(gap2, square * square);
    // And the tip is no lower than where it is within a radius of the box.
    const double u = x * m.dx + y * m.dy;
    const double half = cutter.radius() + std::fabs(m.dx) * width + std::fabs(m.dy) * depth;
    low = from.z() + m.slope * std::clamp(m.slope > 0 ? u - half : u + half, 0.0, m.length);
  }
  // Of the figures below, more than their rounding: no order of moves shows in what is left.
  constexpr double kRounding = 1e-13;
  const double R = cutter.radius();
  const double hair = kRounding * (R + std::fabs(from.x()) + std::fabs(from.y()) + m.length);
  const double gap = std::max(0.0, std::sqrt(gap2) - hair);
  if (gap > R) return kInfinity;
  return low + cutter.height(gap) - std::fabs(m.slope) * hair -
         kRounding * (std::fabs(from.z()) + std::fabs(to.z()));
}

float rounded_up(double v) {
  const float f = static_cast<float>(v);
  return static_cast<double>(f) < v ? std::nextafter(f, std::numeric_limits<float>::infinity()) : f;
}

struct IndexSpan {
  std::size_t first = 1, last = 0;
};

IndexSpan index_span(double lo, double hi, double from, double step, std::size_t count) {
  const double a = std::ceil((lo - from) / step - 1e-9), b = std::floor((hi - from) / step + 1e-9);
  if (b < 0 || a > static_cast<double>(count) - 1 || a > b) return {};
  return {static_cast<std::size_t>(std::max(a, 0.0)),
          static_cast<std::size_t>(std::min(b, static_cast<double>(count) - 1))};
}

}  // namespace

double swept_height(const CutterShape& cutter, const SweepMove& move, double x, double y) {
  return height_over(cutter, planned(move), x, y);
}

SweptHeights::SweptHeights(const CutterShape& cutter, const PlanLattice& lattice,
                           const std::vector<double>& surface)
    : cutter_(cutter),
      lattice_(lattice),
      surface_(&surface),
      tile_columns_((lattice.columns + kTile - 1) / kTile),
      tile_rows_((lattice.rows + kTile - 1) / kTile),
      heights_(lattice.columns * lattice.rows, kInfinity),
      over_(heights_.size(), std::numeric_limits<float>::infinity()),
      highest_(tile_columns_ * tile_rows_, kInfinity) {}

// One call of cut(): the moves by the blocks of tiles they come over, then block by block.
class SweptHeights::Cutting {
 public:
  Cutting(SweptHeights& swept, std::span<const SweepMove> moves)
      : swept_(swept),
        cutter_(swept.cutter_),
        lattice_(swept.lattice_),
        across_((swept.tile_columns_ + kBlock - 1) / kBlock),
        over_block_(across_ * ((swept.tile_rows_ + kBlock - 1) / kBlock)) {
    moves_.reserve(moves.size());
    for (const SweepMove& move : moves) moves_.push_back(planned(move));
    for (std::uint32_t k = 0; k < moves_.size(); ++k) enter(k);
  }

  void run(int threads) {
    parallel_blocks(over_block_.size(), 1, threads, [&](std::size_t begin, std::size_t end, int) {
      std::vector<Bounded> order;
      for (std::size_t block = begin; block < end; ++block) {
        if (!over_block_[block].empty()) cut_block(block, order);
      }
    });
  }

 private:
  static constexpr std::size_t kPoints = kBlock * kTile;  // along a block's side
  struct Tiles {
    std::size_t i0, i1, j0, j1;
  };
  struct Bounded {
    double low;
    std::uint32_t move;
  };

  // A tile's cells reach to the first points of the next.
  static std::size_t first_block(std::size_t point) {
    return (point - std::min<std::size_t>(point, 1)) / kPoints;
  }
  void enter(std::uint32_t k);
  [[nodiscard]] PlanBox box_of(const Tiles& tiles) const;
  [[nodiscard]] double top_of(const Tiles& tiles) const;
  void cut_block(std::size_t block, std::vector<Bounded>& order) const;
  [[nodiscard]] bool cut_tiles(const Tiles& tiles, const PlannedMove& m, double low) const;
  [[nodiscard]] double cut_tile(std::size_t ti, std::size_t tj, const PlannedMove& m) const;

  SweptHeights& swept_;
  const CutterShape& cutter_;
  const PlanLattice& lattice_;
  std::size_t across_;  // blocks along x
  std::vector<PlannedMove> moves_;
  std::vector<std::vector<std::uint32_t>> over_block_;
};

void SweptHeights::Cutting::enter(std::uint32_t k) {
  const double R = cutter_.radius();
  const auto& [from, to] = moves_[k].move;
  const IndexSpan rows = index_span(std::min(from.y(), to.y()) - R, std::max(from.y(), to.y()) + R,
                                    lattice_.y0, lattice_.dy, lattice_.rows);
  if (rows.first > rows.last) return;
  for (std::size_t bj = first_block(rows.first); bj <= rows.last / kPoints; ++bj) {
    const double y0 = lattice_.y(bj * kPoints),
                 y1 = lattice_.y(std::min(bj * kPoints + kPoints, lattice_.rows - 1));
    const auto [x0, x1] = moves_[k].between(y0 - R, y1 + R);
    const IndexSpan columns =
        index_span(x0 - R, x1 + R, lattice_.x0, lattice_.dx, lattice_.columns);
    if (columns.first > columns.last) continue;
    for (std::size_t bi = first_block(columns.first); bi <= columns.last / kPoints; ++bi) {
      over_block_[bj * across_ + bi].push_back(k);
    }
  }
}

PlanBox SweptHeights::Cutting::box_of(const Tiles& tiles) const {
  return {lattice_.x(tiles.i0 * kTile),
          lattice_.x(std::min(tiles.i1 * kTile, lattice_.columns - 1)),
          lattice_.y(tiles.j0 * kTile), lattice_.y(std::min(tiles.j1 * kTile, lattice_.rows - 1))};
}

double SweptHeights::Cutting::top_of(const Tiles& tiles) const {
  double top = -kInfinity;
  for (std::size_t tj = tiles.j0; tj < tiles.j1; ++tj) {
    for (std::size_t ti = tiles.i0; ti < tiles.i1; ++ti) {
      top = std::max(top, swept_.highest_[tj * swept_.tile_columns_ + ti]);
    }
  }
  return top;
}

void SweptHeights::Cutting::cut_block(std::size_t block, std::vector<Bounded>& order) const {
  const std::size_t ti = block % across_ * kBlock, tj = block / across_ * kBlock;
  const Tiles tiles{ti, std::min(ti + kBlock, swept_.tile_columns_), tj,
                    std::min(tj + kBlock, swept_.tile_rows_)};
  // The lowest first: they leave so little that most of the others cut nothing.
  const PlanBox box = box_of(tiles);
  double highest = top_of(tiles);
  order.clear();
  for (const std::uint32_t k : over_block_[block]) {
    const double low = lowest_in(cutter_, moves_[k], box);
    if (low < highest) order.push_back({low, k});
  }
  std::sort(order.begin(), order.end(), [](const Bounded& p, const Bounded& q) {
    return p.low != q.low ? p.low < q.low : p.move < q.move;
  });
  for (const Bounded& next : order) {
    if (next.low >= highest) break;
    if (cut_tiles(tiles, moves_[next.move], next.low)) highest = top_of(tiles);
  }
}

// `low`: nothing the move leaves over the tiles is lower. False where it cuts in none of them.
bool SweptHeights::Cutting::cut_tiles(const Tiles& tiles, const PlannedMove& m, double low) const {
  bool cuts = false;
  for (std::size_t tj = tiles.j0; tj < tiles.j1; ++tj) {
    for (std::size_t ti = tiles.i0; ti < tiles.i1; ++ti) {
      double& top = swept_.highest_[tj * swept_.tile_columns_ + ti];
      // A move that stays above all that is left over the tile cuts nothing there.
      if (low >= top || lowest_in(cutter_, m, box_of({ti, ti + 1, tj, tj + 1})) >= top) continue;
      top = cut_tile(ti, tj, m);
      cuts = true;
    }
  }
  return cuts;
}

// The tile's own points, and the cells behind them. Returns what a move must come below from now
// on to change anything there.
double SweptHeights::Cutting::cut_tile(std::size_t ti, std::size_t tj, const PlannedMove& m) const {
  const std::vector<double>& part = *swept_.surface_;
  const std::size_t i0 = ti * kTile, i1 = std::min(i0 + kTile, lattice_.columns - 1);
  const std::size_t j0 = tj * kTile, j1 = std::min(j0 + kTile, lattice_.rows - 1);
  const std::size_t width = i1 - i0 + 1;
  std::array<double, (kTile + 1) * (kTile + 1)> z;
  for (std::size_t j = j0; j <= j1; ++j) {
    for (std::size_t i = i0; i <= i1; ++i) {
      z[(j - j0) * width + (i - i0)] = height_over(cutter_, m, lattice_.x(i), lattice_.y(j));
    }
  }
  double most = -kInfinity;
  for (std::size_t j = j0; j < std::min(j0 + kTile, lattice_.rows); ++j) {
    for (std::size_t i = i0; i < std::min(i0 + kTile, lattice_.columns); ++i) {
      const std::size_t k = j * lattice_.columns + i, c = (j - j0) * width + (i - i0);
      double& height = swept_.heights_[k];
      height = std::min(height, z[c]);
      most = std::max(most, height);
      if (i == i1 || j == j1) continue;
      const double p0 = part[k], p1 = part[k + 1], p2 = part[k + lattice_.columns],
                   p3 = part[k + lattice_.columns + 1];
      if (std::isnan(p0 + p1 + p2 + p3)) continue;  // at a hole
      float& over_cell = swept_.over_[k];
      const double over = std::max(std::max(z[c] - p0, z[c + 1] - p1),
                                   std::max(z[c + width] - p2, z[c + width + 1] - p3));
      if (over < static_cast<double>(over_cell)) over_cell = rounded_up(over);
      most = std::max(
          most, std::min(std::min(p0, p1), std::min(p2, p3)) + static_cast<double>(over_cell));
    }
  }
  return most;
}

void SweptHeights::cut(std::span<const SweepMove> moves, int threads) {
  Cutting(*this, moves).run(threads);
}

}  // namespace diesink
