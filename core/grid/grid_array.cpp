// Source: Choi et al. 1988, overall procedure (f) and Fig. 8.
// SPDX-License-Identifier: Apache-2.0
#include "core/grid/grid_array.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <string>

namespace diesink {
namespace {

// A last interval below this part of the spacing is the rounding of the one before it.
constexpr double kLeastInterval = 1e-6;

}  // namespace

std::vector<double> grid_lines(double low, double high, double interval) {
  std::vector<double> lines;
  lines.reserve(static_cast<std::size_t>((high - low) / interval) + 2);
  for (std::size_t i = 0;; ++i) {
    const double at = low + static_cast<double>(i) * interval;
    if (at >= high - kLeastInterval * interval) break;
    lines.push_back(at);
  }
  if (lines.empty()) lines.push_back(low);  // an interval longer than the range
  lines.push_back(high);
  return lines;
}

GridArray::GridArray(std::vector<double> x_lines, std::vector<double> y_lines)
    : x_(std::move(x_lines)), y_(std::move(y_lines)) {
  const std::size_t count = size();
  z_ = std::make_unique_for_overwrite<double[]>(count);
  nx_ = std::make_unique_for_overwrite<double[]>(count);
  ny_ = std::make_unique_for_overwrite<double[]>(count);
  nz_ = std::make_unique_for_overwrite<double[]>(count);
  label_ = std::make_unique_for_overwrite<Label[]>(count);
}

std::optional<CcDatum> GridArray::at(const CompoundSurface& surface, std::size_t index) const {
  const Label label = label_[index];
  if (label == kNoLabel) return std::nullopt;
  CcDatum datum;
  datum.z = z_[index];
  datum.n = Vec3(nx_[index], ny_[index], nz_[index]);
  datum.row = row_of(label);
  datum.face = face_of(label);
  datum.surface = surface.surface_of_row(datum.row);
  return datum;
}

CcRun GridArray::row(std::size_t j) {
  const std::size_t at = j * columns();
  return {z_.get() + at, nx_.get() + at, ny_.get() + at, nz_.get() + at, label_.get() + at};
}

void fill_grid(const CompoundSurface& surface, GridArray& grid, int threads) {
  if (grid.size() > 0) surface.grid(grid.x(), grid.y(), grid.row(0), threads);
}

Result<GridArray> evaluate_grid(const CompoundSurface& surface, std::vector<double> x_lines,
                                std::vector<double> y_lines, int threads) {
  const std::size_t columns = x_lines.size(), rows = y_lines.size();
  const auto too_large = [&](const char* expected) {
    return Error{ErrorCode::kLimit,
                 "a grid of " + std::to_string(columns) + " by " + std::to_string(rows) +
                     " points; expected " + expected,
                 {}};
  };
  if (columns != 0 && rows > kMaxGridPoints / columns)
    return too_large("at most 100 million points");
  try {
    GridArray grid(std::move(x_lines), std::move(y_lines));
    fill_grid(surface, grid, threads);
    return grid;
  } catch (const std::bad_alloc&) {
    return too_large("one that memory can hold");
  }
}

Result<GridArray> evaluate_grid(const CompoundSurface& surface, int threads) {
  const Machining& m = surface.program().machining;
  return evaluate_grid(surface, grid_lines(m.x_range[0], m.x_range[1], m.x_interval),
                       grid_lines(m.y_range[0], m.y_range[1], m.y_interval), threads);
}

}  // namespace diesink
