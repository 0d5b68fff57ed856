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

struct CcContact;
struct PassedMove;
class MoveBins;

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
    // Where the points are so far apart that more than the limit may stay between them, though it
    // does not at any of them.
    double unsettled = 0;
  };
  Rest rest();

  // The most that stands over a point of the lattice, straight up, where more than `limit` stays
  // and no cutter fits.
  [[nodiscard]] double highest_out_of_reach();

  // What a place on the surface is where `top` stands over it, whether one of the lattice's or not.
  struct Seen {
    double height = 0;        // of what stays, where that is more than `call` and can be cut
    Vec3 tip = Vec3::Zero();  // where from, then: of the offset's cutter
  };
  [[nodiscard]] Seen see(const CcContact& at, double top) const;
  // Whether a cutter that touches the surface there, with nothing of it in the part, leaves less.
  [[nodiscard]] bool fits_at(const CcContact& at, double top) const;
  // What stands at the nearest point of the lattice, along the normal; 0 where nothing is known.
  [[nodiscard]] double stands_near(const Vec2& at) const;
  // Whether that falls off steeply, as at a ridge beside a wall.
  [[nodiscard]] bool falls_off_at(const Vec2& at) const;

  [[nodiscard]] const LeftOverLimits& limits() const { return limits_; }
  [[nodiscard]] double spacing() const { return step_; }
  // A run may pass its tips by so far in plan, and the rim still meets what is between them.
  [[nodiscard]] double beside_run() const { return beside_run_ / 2; }
  [[nodiscard]] std::size_t rows() const { return rows_; }

 private:
  struct Move {
    Vec3 from, to;
  };
  // kCut: a run was put over it; kNowhere: nor from beside; kDone: no more than `call` stays.
  enum class Fit : std::uint8_t { kUnknown, kYes, kCut, kNo, kNowhere, kDone };
  // Where a cutter should go, and how much more than it would stays at a point; 0 for none.
  struct Place {
    double height = 0;
    Vec3 tip = Vec3::Zero();  // kNoContact high where equation (6) gave it
  };
  struct Points {
    std::vector<double> z, left;  // of the surface, NaN where nothing is asked; of what stays
    std::vector<float> nx, ny, nz;
    // What may stand straight up over it for that no more than `call` stays, then and with less.
    std::vector<float> most;
    std::vector<Fit> fit;
    // By how much more may stay near a point than at it, than `limit` is above `call`.
    std::vector<float> slack;
    std::size_t beside_step = 1;  // one in so many is tried from beside

    void resize(std::size_t count);
  };
  // Points of a tile's cells, cell by cell, in each ascending in x.
  struct Between : Points {
    std::vector<double> x, y;
    std::vector<float> area;           // in plan, each point's part
    std::vector<std::uint32_t> begin;  // of each cell; kNone: it has none
  };
  static constexpr std::uint32_t kNone = 0xffffffff;
  static constexpr double kLeastCosine = 0.05;  // of normals, where a height is divided by it
  // The square between four points of the lattice.
  struct Cell {
    std::uint8_t nx = 1, ny = 1;  // points to a side; 1 and 1 where its corners say enough
    bool smooth = true;           // no edge passes
    bool border = false;          // the surface ends or the domain does: nx points there instead
    bool open = false;            // of more points than its corners, and they are still to be made
    float slack = 0;              // of its points
    [[nodiscard]] std::size_t points() const { return std::size_t{nx} * ny; }
  };

  // A point that the moves may still lower: over one with little enough left they pass on.
  struct OpenPoint {
    Vec2 at;
    double left, done;
    double* kept;
  };
  // Those of a square of kPart cells, at most `top` high.
  struct OpenPart {
    PlanBox box;
    std::size_t begin = 0, end = 0;
    double top = 0;
  };
  struct OpenTile {
    bool taken = false;
    std::vector<OpenPoint> points;
    std::vector<OpenPart> parts;
  };

  // Takes what the surface has at a point.
  void take(Points& points, std::size_t k, const Vec2& at) const;
  void take(Points& points, std::size_t k, const Vec2& at, double z, const Vec3& normal) const;
  [[nodiscard]] Points one(const CcContact& at, double top) const;
  // Whether the offset's cutter at `tip` makes the real one leave less over a place.
  [[nodiscard]] bool lowers(const Vec3& tip, const Vec2& at, double top) const;
  [[nodiscard]] double call(const Points& points, std::size_t k) const {
    return limits_.call - static_cast<double>(points.slack[k]);
  }
  [[nodiscard]] std::size_t nearest_point(const Vec2& at) const;
  // Those of a row of the lattice.
  void take_row(std::size_t j, std::span<const PlanBox> places);
  void divide_cells();
  [[nodiscard]] Cell cell_of(std::size_t i, std::size_t j) const;
  // Makes the points of a cell.
  void add_between(std::size_t i, std::size_t j);
  // Where the surface and the domain end on the sides of a cell.
  [[nodiscard]] std::vector<Vec2> ends_of(std::size_t i, std::size_t j) const;
  // A little beyond them: a cutter that comes over these leaves nothing between them.
  [[nodiscard]] std::vector<Vec2> beyond_ends(std::size_t i, std::size_t j,
                                              const Between& points) const;
  // Of all cells that are still without.
  void add_between();
  [[nodiscard]] std::size_t tile_of(std::size_t i, std::size_t j) const {
    return j / kTile * tiles_ + i / kTile;
  }
  [[nodiscard]] double own_area(std::size_t k) const;
  void flush();
  // The moves over a block of kTile rows and the bands behind them, nearest first: they leave so
  // little that most of the others are passed over.
  void cut_block(std::size_t block, std::span<const PassedMove> moves, const MoveBins& bins);
  // Makes the points of its cells that no move covers, and takes those that stay open.
  void take_open(std::size_t block, std::size_t t, const MoveBins& bins, OpenTile& tile);
  // Whether a cutter on one move leaves so little at the corners of a cell, above the surface's
  // own bend, that it leaves no more than `call` anywhere in it: the cutter is convex. Lowers what
  // is left at its corners then. Needs: the cell is smooth.
  bool cover(std::size_t i, std::size_t j, const MoveBins& bins);
  // The most that is left over the points that stay open.
  double cut_tile(OpenTile& tile, const PassedMove& move);
  // What stays at a point: along the normal, or the distance to the surface where that is more than
  // `call` and the surface ends before; 0 where nothing is asked of it.
  [[nodiscard]] double stays(const Points& points, std::size_t k, const Vec2& at) const;
  // From what is left to the surface, by a search from a place near its foot: a little more than it
  // is, or any distance below `enough`.
  [[nodiscard]] double distance(const Vec3& top, const Vec2& foot, double above,
                                double enough) const;
  [[nodiscard]] Vec3 tip(const Points& points, std::size_t k, const Vec2& at) const;
  [[nodiscard]] bool fits(Points& points, std::size_t k, const Vec2& at) const;
  // Adds the points of a row where more than `call` stays to its runs; of a band the worst between
  // two columns.
  void add_row_runs(std::size_t j, std::vector<std::vector<Vec3>>& runs);
  void add_cell_run(Between& points, std::size_t i, std::size_t j, std::size_t& last,
                    std::vector<std::vector<Vec3>>& runs);
  void add_band_runs(std::size_t j, std::vector<std::vector<Vec3>>& runs);
  void add_to_runs(Vec3 tip, bool goes_on, std::vector<std::vector<Vec3>>& runs);
  // More than `least` stays, and the cutter fits by equation (6) or from beside.
  [[nodiscard]] Place place(Points& points, std::size_t k, const Vec2& at, double least) const;
  // Where what is left falls off steeply, as at a ridge beside a wall or at the domain's side, a
  // cutter that stands free holds it deeper than `least`, though none touches the point itself.
  [[nodiscard]] Place beside(Points& points, std::size_t k, const Vec2& at, double least) const;
  // Whether points of the lattice under a cutter of the offset's keep its tip from coming as low as
  // `tip`: the nearest to its axis, and where it would touch their plane.
  [[nodiscard]] bool kept_above(const Vec2& at, double tip) const;
  // So do some of those all round.
  [[nodiscard]] bool kept_above_all_round(const Vec2& at, double tip) const;
  [[nodiscard]] bool keeps_above(const Vec2& at, double tip, const Vec2& point,
                                 std::size_t& k) const;
  [[nodiscard]] bool in_domain(const Vec2& at) const;
  [[nodiscard]] bool falls_off(const Points& points, std::size_t k, const Vec2& at) const;
  [[nodiscard]] double x(std::size_t i) const { return x0_ + static_cast<double>(i) * dx_; }
  [[nodiscard]] double y(std::size_t j) const { return y0_ + static_cast<double>(j) * dy_; }
  [[nodiscard]] Vec2 at_lattice(std::size_t k) const { return {x(k % columns_), y(k / columns_)}; }
  // Where a cutter has to come over for a point of the lattice: on its outer rows and columns,
  // where the domain may end, a little beyond.
  [[nodiscard]] Vec2 beyond_lattice(std::size_t i, std::size_t j) const {
    const double by = beside_run();
    return {i == 0              ? x0_ - by
            : i + 1 == columns_ ? x(i) + by
                                : x(i),
            j == 0           ? y0_ - by
            : j + 1 == rows_ ? y(j) + by
                             : y(j)};
  }

  const CompoundSurface* surface_;
  const OffsetSurface* offset_;
  const PointDrop* drop_;
  CutterShape cutter_;
  FrameDomain domain_;
  LeftOverLimits limits_;
  int threads_;
  PlanBox reach_;  // where a tip may lower what stays
  double x0_ = 0, y0_ = 0, dx_ = 1, dy_ = 1, per_x_ = 1, per_y_ = 1;
  double step_ = 1;  // at least dx_ and dy_
  double hair_ = 0;  // rounding of the domain's sides
  double rim_ = 0;   // of the way from a tip to its contact
  double beside_run_ = 0;
  bool everywhere_ = true;
  std::size_t columns_ = 0, rows_ = 0;
  int most_parts_ = 16;  // to a side of a cell
  Points lattice_;
  std::vector<Cell> cells_;       // by the lattice's point at the low corner
  std::vector<Between> between_;  // of each tile
  std::vector<Move> waiting_;
  // Tiles of kTile rows and columns and what is between their points.
  static constexpr std::size_t kTile = 16;
  static constexpr std::size_t kPart = 4;
  static constexpr std::size_t kRowsABlock = 16;  // for one thread
  std::size_t tiles_ = 0;                         // side by side
  std::vector<double> highest_;
};

}  // namespace diesink
