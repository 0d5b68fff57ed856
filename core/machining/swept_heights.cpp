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

void SweptHeights::cut(std::span<const SweepMove> moves, int threads) {
  const CutterShape& cutter = cutter_;
  const PlanLattice& lattice = lattice_;
  const double R = cutter.radius();
  const std::size_t across = (tile_columns_ + kBlock - 1) / kBlock;
  const std::size_t blocks = across * ((tile_rows_ + kBlock - 1) / kBlock);
  std::vector<PlannedMove> all;
  all.reserve(moves.size());
  for (const SweepMove& move : moves) all.push_back(planned(move));
  // Moves by the blocks they come over. A tile's cells reach to the first points of the next.
  std::vector<std::vector<std::uint32_t>> items(blocks);
  constexpr std::size_t kPoints = kBlock * kTile;
  const auto first_block = [](std::size_t point) {
    return (point - std::min<std::size_t>(point, 1)) / kPoints;
  };
  for (std::uint32_t k = 0; k < all.size(); ++k) {
    const auto& [from, to] = all[k].move;
    const IndexSpan rows =
        index_span(std::min(from.y(), to.y()) - R, std::max(from.y(), to.y()) + R, lattice.y0,
                   lattice.dy, lattice.rows);
    if (rows.first > rows.last) continue;
    for (std::size_t bj = first_block(rows.first); bj <= rows.last / kPoints; ++bj) {
      const double y0 = lattice.y(bj * kPoints),
                   y1 = lattice.y(std::min(bj * kPoints + kPoints, lattice.rows - 1));
      const auto [x0, x1] = all[k].between(y0 - R, y1 + R);
      const IndexSpan columns = index_span(x0 - R, x1 + R, lattice.x0, lattice.dx, lattice.columns);
      if (columns.first > columns.last) continue;
      for (std::size_t bi = first_block(columns.first); bi <= columns.last / kPoints; ++bi) {
        items[bj * across + bi].push_back(k);
      }
    }
  }
  const std::vector<double>& part = *surface_;
  parallel_blocks(blocks, 1, threads, [&](std::size_t begin, std::size_t end, int) {
    std::array<double, (kTile + 1) * (kTile + 1)> z;
    struct Bounded {
      double low;
      std::uint32_t item;
    };
    std::vector<Bounded> order;
    for (std::size_t block = begin; block < end; ++block) {
      if (items[block].empty()) continue;
      const std::size_t ti0 = block % across * kBlock, tj0 = block / across * kBlock;
      const std::size_t ti1 = std::min(ti0 + kBlock, tile_columns_),
                        tj1 = std::min(tj0 + kBlock, tile_rows_);
      const auto box_of = [&](std::size_t i0, std::size_t i1, std::size_t j0, std::size_t j1) {
        return PlanBox{lattice.x(i0 * kTile), lattice.x(std::min(i1 * kTile, lattice.columns - 1)),
                       lattice.y(j0 * kTile), lattice.y(std::min(j1 * kTile, lattice.rows - 1))};
      };
      const auto block_top = [&] {
        double top = -kInfinity;
        for (std::size_t tj = tj0; tj < tj1; ++tj) {
          for (std::size_t ti = ti0; ti < ti1; ++ti) {
            top = std::max(top, highest_[tj * tile_columns_ + ti]);
          }
        }
        return top;
      };
      // The lowest first: they leave so little that most of the others cut nothing.
      const PlanBox box = box_of(ti0, ti1, tj0, tj1);
      double highest = block_top();
      order.clear();
      for (const std::uint32_t item : items[block]) {
        const double low = lowest_in(cutter, all[item], box);
        if (low < highest) order.push_back({low, item});
      }
      std::sort(order.begin(), order.end(), [](const Bounded& p, const Bounded& q) {
        return p.low != q.low ? p.low < q.low : p.item < q.item;
      });
      for (const Bounded& next : order) {
        if (next.low >= highest) break;
        const PlannedMove& m = all[next.item];
        bool cuts = false;
        for (std::size_t tj = tj0; tj < tj1; ++tj) {
          const std::size_t j0 = tj * kTile, j1 = std::min(j0 + kTile, lattice.rows - 1);
          for (std::size_t ti = ti0; ti < ti1; ++ti) {
            double& top = highest_[tj * tile_columns_ + ti];
            // A move that stays above all that is left over the tile cuts nothing there.
            if (next.low >= top || lowest_in(cutter, m, box_of(ti, ti + 1, tj, tj + 1)) >= top) {
              continue;
            }
            cuts = true;
            const std::size_t i0 = ti * kTile, i1 = std::min(i0 + kTile, lattice.columns - 1);
            const std::size_t width = i1 - i0 + 1;
            for (std::size_t j = j0; j <= j1; ++j) {
              for (std::size_t i = i0; i <= i1; ++i) {
                z[(j - j0) * width + (i - i0)] = height_over(cutter, m, lattice.x(i), lattice.y(j));
              }
            }
            // The tile's own points, and the cells behind them.
            double most = -kInfinity;
            for (std::size_t j = j0; j < std::min(j0 + kTile, lattice.rows); ++j) {
              for (std::size_t i = i0; i < std::min(i0 + kTile, lattice.columns); ++i) {
                const std::size_t k = j * lattice.columns + i, c = (j - j0) * width + (i - i0);
                heights_[k] = std::min(heights_[k], z[c]);
                most = std::max(most, heights_[k]);
                if (i == i1 || j == j1) continue;
                const double p0 = part[k], p1 = part[k + 1], p2 = part[k + lattice.columns],
                             p3 = part[k + lattice.columns + 1];
                if (std::isnan(p0 + p1 + p2 + p3)) continue;  // at a hole
                const double over = std::max(std::max(z[c] - p0, z[c + 1] - p1),
                                             std::max(z[c + width] - p2, z[c + width + 1] - p3));
                if (over < static_cast<double>(over_[k])) over_[k] = rounded_up(over);
                most = std::max(most, std::min(std::min(p0, p1), std::min(p2, p3)) +
                                          static_cast<double>(over_[k]));
              }
            }
            top = most;
          }
        }
        if (cuts) highest = block_top();
      }
    }
  });
}

}  // namespace diesink
