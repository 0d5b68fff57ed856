// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/deviation_base.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

namespace diesink {
namespace {

// The finest cells: this many along a patch, but not more than kMostCells in all.
constexpr int kCellsAlongPatch = 16;
constexpr int kMostCells = 1 << 18;

constexpr float kFloatInf = std::numeric_limits<float>::infinity();

float rounded_down(double v) {
  const float f = static_cast<float>(v);
  return static_cast<double>(f) > v ? std::nextafterf(f, -kFloatInf) : f;
}

float rounded_up(double v) {
  const float f = static_cast<float>(v);
  return static_cast<double>(f) < v ? std::nextafterf(f, kFloatInf) : f;
}

struct FloatRange {
  float lo = kFloatInf, hi = -kFloatInf;

  void keep(const Range& r) {
    lo = rounded_down(r.lo);
    hi = rounded_up(r.hi);
  }
};

struct Enclosure {
  FloatRange zx, zy, zxx, zxy, zyy;
  bool covered = false;
};

Enclosure enclosure(const FergusonSurface& surface, const PlanBox& box) {
  Enclosure out;
  const BaseBounds b = surface.bounds(box);
  if (b.coverage == Coverage::kOutside) return out;
  out.covered = true;
  out.zx.keep(b.zx);
  out.zy.keep(b.zy);
  out.zxx.keep(b.zxx);
  out.zxy.keep(b.zxy);
  out.zyy.keep(b.zyy);
  return out;
}

void widen(Range& r, const FloatRange& by) {
  r.lo = std::fmin(r.lo, static_cast<double>(by.lo));
  r.hi = std::fmax(r.hi, static_cast<double>(by.hi));
}

enum CellState : int { kEmpty, kBusy, kReady };

}  // namespace

struct BaseCurvature::Cell {
  std::atomic<int> state{kEmpty};
  Enclosure kept;
};

BaseCurvature::BaseCurvature(const FergusonSurface& surface)
    : surface_(&surface), box_(surface.plan_box()) {
  // A power of two of columns and rows near the wanted number, so that cells halve.
  const auto depth = [](int spans) {
    return static_cast<int>(std::ceil(std::log2(static_cast<double>(spans * kCellsAlongPatch))));
  };
  const double w = box_.x1 - box_.x0, h = box_.y1 - box_.y0;
  // Patches need not lie along the axes of the plan: cells are made about square.
  int deepest = std::max(depth(surface.columns() - 1), depth(surface.rows() - 1));
  const double longest = std::fmax(w, h);
  const auto count = [&](double side, int level) {
    return static_cast<int>(std::ceil(std::ldexp(side / longest, level) - 1e-9));
  };
  const auto cells = [&](int level) {
    return static_cast<double>(std::max(1, count(w, level))) * std::max(1, count(h, level));
  };
  while (deepest > 0 && cells(deepest) > kMostCells) --deepest;
  for (int k = 0; k <= deepest; ++k) {
    Level level;
    level.columns = std::max(1, count(w, k));
    level.rows = std::max(1, count(h, k));
    level.width = w / level.columns;
    level.height = h / level.rows;
    level.cells = std::make_unique<Cell[]>(static_cast<std::size_t>(level.columns) *
                                           static_cast<std::size_t>(level.rows));
    levels_.push_back(std::move(level));
  }
}

BaseCurvature::~BaseCurvature() = default;
BaseCurvature::BaseCurvature(BaseCurvature&&) noexcept = default;
BaseCurvature& BaseCurvature::operator=(BaseCurvature&&) noexcept = default;

void BaseCurvature::take(const Level& level, int column, int row, BaseShape& shape,
                         bool& any) const {
  Cell& cell = level.cells[static_cast<std::size_t>(row) * static_cast<std::size_t>(level.columns) +
                           static_cast<std::size_t>(column)];
  Enclosure own;
  const Enclosure* found = &cell.kept;
  if (cell.state.load(std::memory_order_acquire) != kReady) {
    // A little wider than the cell: rounding of its borders must not lose a strip.
    const double mx = 1e-9 * level.width, my = 1e-9 * level.height;
    own = enclosure(*surface_,
                    {box_.x0 + column * level.width - mx, box_.x0 + (column + 1) * level.width + mx,
                     box_.y0 + row * level.height - my, box_.y0 + (row + 1) * level.height + my});
    found = &own;
    // Only one thread writes; another that comes meanwhile uses its own equal copy.
    int expected = kEmpty;
    if (cell.state.compare_exchange_strong(expected, kBusy, std::memory_order_acquire)) {
      cell.kept = own;
      cell.state.store(kReady, std::memory_order_release);
    }
  }
  if (!found->covered) return;
  if (!any)
    shape = {{HUGE_VAL, -HUGE_VAL},
             {HUGE_VAL, -HUGE_VAL},
             {HUGE_VAL, -HUGE_VAL},
             {HUGE_VAL, -HUGE_VAL},
             {HUGE_VAL, -HUGE_VAL}};
  any = true;
  widen(shape.zx, found->zx);
  widen(shape.zy, found->zy);
  widen(shape.zxx, found->zxx);
  widen(shape.zxy, found->zxy);
  widen(shape.zyy, found->zyy);
}

bool BaseCurvature::over(const PlanBox& box, BaseShape& shape) const {
  // The finest level whose cells are at least half the box: then it meets at most 3 x 3 of them.
  std::size_t k = levels_.size() - 1;
  while (k > 0 &&
         (box.x1 - box.x0 > 2 * levels_[k].width || box.y1 - box.y0 > 2 * levels_[k].height)) {
    --k;
  }
  const Level& level = levels_[k];
  const auto cell_at = [](double offset, double side, int cells) {
    return static_cast<int>(std::clamp(std::floor(offset / side), 0.0, cells - 1.0));
  };
  const int c0 = cell_at(box.x0 - box_.x0, level.width, level.columns),
            c1 = cell_at(box.x1 - box_.x0, level.width, level.columns);
  const int r0 = cell_at(box.y0 - box_.y0, level.height, level.rows),
            r1 = cell_at(box.y1 - box_.y0, level.height, level.rows);
  bool any = false;
  for (int r = r0; r <= r1; ++r) {
    for (int c = c0; c <= c1; ++c) take(level, c, r, shape, any);
  }
  return any;
}

}  // namespace diesink
