// What the moves made so far leave over the surface, at the points of a lattice: the planner's own
// look, for cutters and methods whose passes do not bound it by themselves.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/compound/compound_surface.h"
#include "core/machining/drop.h"
#include "core/machining/frame_domain.h"

namespace diesink {

struct LeftOverLimits {
  double call = 0;   // what may stay, along the normal, before a place is called out
  double limit = 0;  // what may stay in the end; at least `call`
  double touch = 0;  // a cutter on the point that meets no more than this of the part fits there
};

class LeftOver {
 public:
  // `cutter` is the one that cuts, the offset's may be larger or smaller; `spacing` of the lattice,
  // wider where that gives more than two million points. Everything is in the frame of `offset`.
  // Needs: `surface` known over the domain; `offset` and `drop` outlive it.
  LeftOver(const CompoundSurface& surface, const OffsetSurface& offset, const PointDrop& drop,
           const CutterShape& cutter, const FrameDomain& domain, const LeftOverLimits& limits,
           double spacing, int threads);

  // A move of the cutter's tip.
  void cut(const Vec3& from, const Vec3& to);

  // The tips that equation (6) gives for the points of every `stride`-th row where more than
  // `call` stays and the cutter fits, neighbours together. Of the offset's cutter.
  std::vector<std::vector<Vec3>> open_runs(std::size_t stride);

  // The plan area where the cutter fits and more than `limit` stays, and the most that does.
  struct Rest {
    double area = 0, height = 0;
  };
  Rest rest();

  [[nodiscard]] double spacing() const { return step_; }
  [[nodiscard]] std::size_t rows() const { return rows_; }

 private:
  struct Move {
    Vec3 from, to;
  };
  void flush();
  void cut_row(std::size_t j, const Move& move);
  // What stays at a point along the normal; 0 where nothing is asked of it.
  [[nodiscard]] double stays(std::size_t k) const;
  [[nodiscard]] Vec3 tip(std::size_t k) const;
  [[nodiscard]] bool fits(std::size_t k);
  [[nodiscard]] double x(std::size_t i) const { return x0_ + static_cast<double>(i) * step_; }
  [[nodiscard]] double y(std::size_t j) const { return y0_ + static_cast<double>(j) * step_; }

  const OffsetSurface* offset_;
  const PointDrop* drop_;
  CutterShape cutter_;
  FrameDomain domain_;
  LeftOverLimits limits_;
  int threads_;
  double x0_ = 0, y0_ = 0, step_ = 1;
  std::size_t columns_ = 0, rows_ = 0;
  std::vector<double> z_, left_;  // of the surface, NaN where nothing is asked; of what stays
  std::vector<float> nx_, ny_, nz_;
  enum class Fit : std::uint8_t { kUnknown, kYes, kNo };
  std::vector<Fit> fit_;
  std::vector<Move> waiting_;
};

}  // namespace diesink
