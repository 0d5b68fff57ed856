// What the moves made so far leave over the surface, at the points of a lattice: the planner's own
// look, for cutters and methods whose passes do not bound it by themselves.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/compound/compound_surface.h"
#include "core/machining/drop.h"
#include "core/machining/frame_domain.h"

namespace diesink {

struct PassedMove;

struct LeftOverLimits {
  double call = 0;   // what may stay, along the normal, before a place is called out
  double limit = 0;  // what may stay in the end; at least `call`
  double fits = 0;   // a cutter fits that comes as close, along the normal, as this
};

class LeftOver {
 public:
  // `cutter` is the one that cuts, the offset's may be larger or smaller; `spacing` of the lattice,
  // wider where that gives more than two million points. On slopes and beside edges there are
  // points between, so that along the surface they are no further apart; up to two million of them.
  // With `places` nothing else is looked at. Everything is in the frame of `offset`.
  // Needs: `surface` known over the domain; all three outlive it.
  LeftOver(const CompoundSurface& surface, const OffsetSurface& offset, const PointDrop& drop,
           const CutterShape& cutter, const FrameDomain& domain, const LeftOverLimits& limits,
           double spacing, int threads, std::span<const PlanBox> places = {});

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
  // kCut: a run was put over it; kNowhere: nor from beside.
  enum class Fit : std::uint8_t { kUnknown, kYes, kCut, kNo, kNowhere };
  // Where a cutter should go, and how much more than it would stays at a point; 0 for none.
  struct Place {
    double height = 0;
    Vec3 tip = Vec3::Zero();  // kNoContact high where equation (6) gave it
  };
  struct Points {
    std::vector<double> z, left;  // of the surface, NaN where nothing is asked; of what stays
    std::vector<float> nx, ny, nz;
    std::vector<Fit> fit;

    void resize(std::size_t count);
    void take(std::size_t k, double height, const Vec3& normal);
  };
  struct Between : Points {  // the rows of the lattice, ascending in x in each band
    std::vector<double> x, y;
    std::vector<std::size_t> begin;  // of each band, and the end
    std::vector<float> area;         // in plan, each point's part
  };

  void add_between(const CompoundSurface& surface);
  // Points to a side of a cell; 1 and 1 where its corners say enough.
  [[nodiscard]] std::array<int, 2> parts_of(std::size_t i, std::size_t j) const;
  [[nodiscard]] double own_area(std::size_t k) const;
  void flush();
  // The moves over a block of kTile rows and the bands behind them, nearest first: they leave so
  // little that most of the others are passed over.
  void cut_block(std::size_t block, std::span<const PassedMove> moves);
  void cut_tile(std::size_t block, std::size_t tile, const PassedMove& move);
  // The most that is left over a tile.
  [[nodiscard]] double highest(std::size_t block, std::size_t tile) const;
  [[nodiscard]] std::array<std::size_t, 2> between_of(std::size_t j, std::size_t tile) const;
  // What stays at a point: along the normal, or the distance to the surface where that is more than
  // `call` and the surface ends before; 0 where nothing is asked of it.
  [[nodiscard]] double stays(const Points& points, std::size_t k, const Vec2& at) const;
  // From what is left to the surface, by a search from a place near its foot: a little more than it
  // is, or any distance below `call`.
  [[nodiscard]] double distance(const Vec3& top, const Vec2& foot, double above) const;
  [[nodiscard]] Vec3 tip(const Points& points, std::size_t k, const Vec2& at) const;
  [[nodiscard]] bool fits(Points& points, std::size_t k, const Vec2& at);
  // Adds the points of a row where more than `call` stays to its runs; of a band the worst between
  // two columns.
  void add_row_runs(std::size_t j, std::vector<std::vector<Vec3>>& runs);
  void add_band_runs(std::size_t j, std::vector<std::vector<Vec3>>& runs);
  void add_to_runs(Vec3 tip, bool goes_on, std::vector<std::vector<Vec3>>& runs);
  // More than `least` stays, and the cutter fits by equation (6) or from beside.
  [[nodiscard]] Place place(Points& points, std::size_t k, const Vec2& at, double least);
  // Where what is left falls off steeply, as at a ridge beside a wall or at the domain's side, a
  // cutter that stands free holds it deeper than `least`, though none touches the point itself.
  [[nodiscard]] Place beside(Points& points, std::size_t k, const Vec2& at, double least) const;
  // Whether a point at the height `top`, rho from the cutter's axis at a place, may be held deeper
  // than `least`: false where points of the lattice there keep the cutter too high.
  [[nodiscard]] bool may_hold(const Vec2& at, double rho, double top, double least) const;
  [[nodiscard]] bool in_domain(const Vec2& at) const;
  [[nodiscard]] bool falls_off(const Points& points, std::size_t k, const Vec2& at) const;
  [[nodiscard]] double x(std::size_t i) const { return x0_ + static_cast<double>(i) * dx_; }
  [[nodiscard]] double y(std::size_t j) const { return y0_ + static_cast<double>(j) * dy_; }
  [[nodiscard]] Vec2 at_lattice(std::size_t k) const { return {x(k % columns_), y(k / columns_)}; }
  [[nodiscard]] Vec2 at_between(std::size_t k) const { return {between_.x[k], between_.y[k]}; }

  const CompoundSurface* surface_;
  const OffsetSurface* offset_;
  const PointDrop* drop_;
  CutterShape cutter_;
  FrameDomain domain_;
  LeftOverLimits limits_;
  int threads_;
  PlanBox reach_;  // where a tip may lower what stays
  double x0_ = 0, y0_ = 0, dx_ = 1, dy_ = 1;
  double step_ = 1;  // at least dx_ and dy_
  double hair_ = 0;  // rounding of the domain's sides
  double rim_ = 0;   // of the way from a tip to its contact
  std::size_t columns_ = 0, rows_ = 0;
  int most_parts_ = 8;  // to a side of a cell
  Points lattice_;
  Between between_;
  std::vector<Move> waiting_;
  // Tiles of kTile rows and columns and what is between their points.
  static constexpr std::size_t kTile = 16;
  static constexpr std::size_t kRowsABlock = 16;  // for one thread
  std::size_t tiles_ = 0;                         // side by side
  std::vector<std::size_t> between_start_;        // of each band the first point of each tile
  std::vector<double> highest_;
};

}  // namespace diesink
