// SPDX-License-Identifier: Apache-2.0
#include "core/machining/swept_heights.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/parallel.h"

namespace diesink {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kTile = 4;  // points a side

// How fast the cutter's lower surface rises along the move at b before its axis and w beside it.
double rise_at(const CutterShape& cutter, double b, double w) {
  const double rho = std::sqrt(b * b + w * w), d = rho - cutter.flat();
  if (d <= 0) return 0;
  const double below = (cutter.corner() - d) * (cutter.corner() + d);
  return below > 0 ? d / std::sqrt(below) * b / rho : std::copysign(kInfinity, b);
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
  } else if (rise_at(cutter, high, w) <= steep) {
    back = high;
  } else {
    // The rise grows with the distance; most often it is too much from the beginning of the piece.
    if (rise_at(cutter, low, w) < steep) {
      for (int k = 0; k < 50 && high - low > 1e-13 * cutter.radius(); ++k) {
        const double b = low + (high - low) / 2;
        (rise_at(cutter, b, w) < steep ? low : high) = b;
      }
    }
    back = low;
  }
  return std::clamp(u + side * back, first, last);
}

struct PlannedMove {
  SweepMove move;
  double dx = 0, dy = 0, length = 0, slope = 0;
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

// Least distance in plan between a move and a box.
double box_distance(const PlannedMove& m, double x0, double x1, double y0, double y1) {
  const double gap_x = std::max(0.0, std::max(x0 - std::max(m.move.from.x(), m.move.to.x()),
                                              std::min(m.move.from.x(), m.move.to.x()) - x1));
  const double gap_y = std::max(0.0, std::max(y0 - std::max(m.move.from.y(), m.move.to.y()),
                                              std::min(m.move.from.y(), m.move.to.y()) - y1));
  // Also square to the move: the box's nearest corner.
  double square = 0;
  if (m.length > 0) {
    const double middle_x = (x0 + x1) / 2 - m.move.from.x(),
                 middle_y = (y0 + y1) / 2 - m.move.from.y();
    const double half = std::fabs(m.dx) * (y1 - y0) / 2 + std::fabs(m.dy) * (x1 - x0) / 2;
    square = std::fabs(middle_y * m.dx - middle_x * m.dy) - half;
  }
  return std::max(square, std::sqrt(gap_x * gap_x + gap_y * gap_y));
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
  constexpr std::size_t kBandTiles = 8;
  const std::size_t bands = (tile_rows_ + kBandTiles - 1) / kBandTiles;
  // Moves by the bands of rows they come over, in their order.
  const auto rows_of = [&](const SweepMove& m) {
    return index_span(std::min(m.from.y(), m.to.y()) - R, std::max(m.from.y(), m.to.y()) + R,
                      lattice.y0, lattice.dy, lattice.rows);
  };
  constexpr std::size_t kBandRows = kBandTiles * kTile;
  std::vector<std::vector<std::uint32_t>> items(bands);
  for (std::size_t k = 0; k < moves.size(); ++k) {
    const IndexSpan rows = rows_of(moves[k]);
    if (rows.first > rows.last) continue;
    // A tile's cells reach to the first points of the next.
    for (std::size_t b = (rows.first - std::min<std::size_t>(rows.first, 1)) / kBandRows;
         b <= rows.last / kBandRows; ++b) {
      items[b].push_back(static_cast<std::uint32_t>(k));
    }
  }
  const std::vector<double>& part = *surface_;
  parallel_blocks(bands, 1, threads, [&](std::size_t begin, std::size_t end, int) {
    std::array<double, (kTile + 1) * (kTile + 1)> z;
    for (std::size_t band = begin; band < end; ++band) {
      const std::size_t tile_end = std::min((band + 1) * kBandTiles, tile_rows_);
      for (const std::uint32_t item : items[band]) {
        const PlannedMove m = planned(moves[item]);
        const double low = std::min(m.move.from.z(), m.move.to.z());
        const IndexSpan rows = rows_of(m.move);
        const IndexSpan columns = index_span(std::min(m.move.from.x(), m.move.to.x()) - R,
                                             std::max(m.move.from.x(), m.move.to.x()) + R,
                                             lattice.x0, lattice.dx, lattice.columns);
        if (columns.first > columns.last) continue;
        const std::size_t first = rows.first - std::min<std::size_t>(rows.first, 1);
        for (std::size_t tj = std::max(first / kTile, band * kBandTiles);
             tj <= rows.last / kTile && tj < tile_end; ++tj) {
          const std::size_t j0 = tj * kTile, j1 = std::min(j0 + kTile, lattice.rows - 1);
          const std::size_t left = columns.first - std::min<std::size_t>(columns.first, 1);
          for (std::size_t ti = left / kTile; ti <= columns.last / kTile; ++ti) {
            double& top = highest_[tj * tile_columns_ + ti];
            const std::size_t i0 = ti * kTile, i1 = std::min(i0 + kTile, lattice.columns - 1);
            const double gap =
                box_distance(m, lattice.x(i0), lattice.x(i1), lattice.y(j0), lattice.y(j1));
            // A move that stays above all that is left over the tile cuts nothing there.
            if (gap > R || low + cutter.height(gap) >= top) continue;
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
      }
    }
  });
}

}  // namespace diesink
