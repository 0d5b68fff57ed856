// The grid array (paper, Fig. 8): CC-data over the crossings of plan lines.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/compound/compound_surface.h"
#include "core/result.h"

namespace diesink {

// Lines at low, low + interval, ..., and always high; the last interval may be shorter.
// Needs: low < high, interval > 0, and a count that fits memory, which the part program's reader
//        sees to.
std::vector<double> grid_lines(double low, double high, double interval);

// CC-data over all crossings of x lines and y lines, structure of arrays: 36 bytes a point.
// Shape: row-major, x fastest: the datum over (x()[i], y()[j]) has index j * columns() + i.
//        Where there is no surface z is NaN, the normal 0 and the label kNoLabel.
class GridArray {
 public:
  GridArray() = default;
  // All values undefined.
  // Needs: lines ascending. Throws std::bad_alloc only.
  GridArray(std::vector<double> x_lines, std::vector<double> y_lines);

  [[nodiscard]] const std::vector<double>& x() const { return x_; }
  [[nodiscard]] const std::vector<double>& y() const { return y_; }
  [[nodiscard]] std::size_t columns() const { return x_.size(); }
  [[nodiscard]] std::size_t rows() const { return y_.size(); }
  [[nodiscard]] std::size_t size() const { return columns() * rows(); }

  [[nodiscard]] std::span<const double> z() const { return {z_.get(), size()}; }
  [[nodiscard]] std::span<const double> nx() const { return {nx_.get(), size()}; }
  [[nodiscard]] std::span<const double> ny() const { return {ny_.get(), size()}; }
  [[nodiscard]] std::span<const double> nz() const { return {nz_.get(), size()}; }
  [[nodiscard]] std::span<const Label> label() const { return {label_.get(), size()}; }

  // The datum of an index; empty where there is no surface.
  [[nodiscard]] std::optional<CcDatum> at(const CompoundSurface& surface, std::size_t index) const;

  // The run of row j, to be filled.
  [[nodiscard]] CcRun row(std::size_t j);

 private:
  std::vector<double> x_, y_;
  // Not vectors: nothing is written before the rows are, each by the thread that computes it.
  std::unique_ptr<double[]> z_, nx_, ny_, nz_;
  std::unique_ptr<Label[]> label_;
};

// Evaluates the surface over all crossings, in parallel by blocks of rows; threads = 0 means all
// cores. The same bytes for any number of threads.
// Errors: kLimit for more points than kMaxGridPoints or than memory holds.
inline constexpr std::size_t kMaxGridPoints = 100'000'000;
Result<GridArray> evaluate_grid(const CompoundSurface& surface, std::vector<double> x_lines,
                                std::vector<double> y_lines, int threads);

// The same over the program's own domain and intervals.
Result<GridArray> evaluate_grid(const CompoundSurface& surface, int threads);

// The same into an array that is there already, whatever it held.
void fill_grid(const CompoundSurface& surface, GridArray& grid, int threads);

}  // namespace diesink
