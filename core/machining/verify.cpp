// SPDX-License-Identifier: Apache-2.0
#include "core/machining/verify.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/machining/cell_bounds.h"
#include "core/machining/gouge_search.h"
#include "core/machining/lattice_check.h"
#include "core/machining/move_merger.h"
#include "core/machining/point_depths.h"
#include "core/machining/swept_heights.h"
#include "core/number.h"
#include "core/parallel.h"

namespace diesink {
namespace {

constexpr double kMostPoints = 5e7;  // of the lattice
constexpr double kUsualPoints = 4e6;
constexpr std::size_t kMovesATime = 16384;
constexpr std::size_t kMostDivided = 60'000;       // cells; 0.7 kilobytes each
constexpr std::size_t kMostDividedFinely = 4'000;  // 8 kilobytes each
constexpr double kClearExcess = 8;                 // of the limit: what tells a path to be wrong
constexpr double kJoinedPart = 1.0 / 256;          // of both tolerances, for moves joined into one

Error input_error(std::string message) { return {ErrorCode::kInput, std::move(message), {}}; }

double percentile(std::vector<float>& values, double part) {
  if (values.empty()) return 0;
  const auto at = static_cast<std::ptrdiff_t>(part * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return static_cast<double>(values[static_cast<std::size_t>(at)]);
}

PlanLattice lattice_over(const Machining& machining, double spacing) {
  PlanLattice lattice;
  const double width = machining.x_range[1] - machining.x_range[0];
  const double depth = machining.y_range[1] - machining.y_range[0];
  lattice.x0 = machining.x_range[0];
  lattice.y0 = machining.y_range[0];
  lattice.columns = static_cast<std::size_t>(std::ceil(width / spacing)) + 1;
  lattice.rows = static_cast<std::size_t>(std::ceil(depth / spacing)) + 1;
  lattice.dx = width / static_cast<double>(lattice.columns - 1);
  lattice.dy = depth / static_cast<double>(lattice.rows - 1);
  return lattice;
}

// Lattice points of the true surface that lie inside a swept volume.
TriangleMesh gouged_points(const PlanLattice& lattice, const std::vector<double>& z,
                           const std::vector<double>& left, double floor) {
  TriangleMesh points;
  for (std::size_t k = 0; k < z.size(); ++k) {
    if (!(z[k] - left[k] > floor)) continue;
    const auto at = static_cast<std::uint32_t>(points.positions.size());
    points.positions.emplace_back(lattice.x(k % lattice.columns), lattice.y(k / lattice.columns),
                                  z[k]);
    points.triangles.push_back({at, at, at});
  }
  return points;
}

// Points of the lattice that the swept volume holds, deeper than `floor` straight down, where the
// surface falls off beside them as only a wall does: sideways they may be hardly in it.
std::vector<std::size_t> points_beside_walls(const PlanLattice& lattice,
                                             const std::vector<double>& z,
                                             const std::vector<double>& left, double floor) {
  constexpr double kWall = 4;  // of the lattice's steps
  constexpr std::size_t kMost = 100'000;
  std::vector<std::size_t> found;
  const double fall = kWall * std::fmax(lattice.dx, lattice.dy);
  for (std::size_t j = 0; j < lattice.rows; ++j) {
    for (std::size_t i = 0; i < lattice.columns; ++i) {
      const std::size_t k = j * lattice.columns + i;
      if (!(z[k] - left[k] > floor)) continue;
      bool wall = false;
      for (std::size_t b = j - std::min<std::size_t>(j, 1); b <= j + 1 && !wall; ++b) {
        for (std::size_t a = i - std::min<std::size_t>(i, 1); a <= i + 1 && !wall; ++a) {
          if (a >= lattice.columns || b >= lattice.rows) continue;
          wall = !(std::fabs(z[k] - z[b * lattice.columns + a]) <= fall);  // or a hole
        }
      }
      if (wall) found.push_back(k);
      if (found.size() == kMost) return found;
    }
  }
  return found;
}

// Walks over the path; calls visit with the moves, joined as far as `tolerance` lets, some at a
// time.
Status each_moves(const PathSource& path, double tolerance,
                  const std::function<void(std::span<const SweepMove>)>& visit,
                  const std::function<void(std::span<const ClPoint>)>& look) {
  MoveMerger merger(tolerance);
  std::vector<SweepMove> moves;
  const auto hand_on = [&](std::size_t least) {
    if (moves.size() < least || moves.empty()) return;
    visit(moves);
    moves.clear();
  };
  Status done = path([&](std::span<const ClPoint> points) {
    look(points);
    for (const ClPoint& point : points) {
      merger.add(point.tip, moves);
      hand_on(kMovesATime);
    }
  });
  if (!done) return done;
  merger.finish(moves);
  hand_on(1);
  return ok();
}

// Lengths, and rapid moves that should not be, over a path that comes in pieces.
class MoveCounter {
 public:
  MoveCounter(double top, VerifyReport& report) : top_(top), report_(report) {}
  void look(std::span<const ClPoint> points) {
    for (const ClPoint& point : points) {
      if (report_.points++ > 0) {
        const Vec3 d = point.tip - last_;
        if (point.motion == Motion::kFeed) {
          report_.length += d.norm();
        } else if (point.tip.z() < top_ && !(d.head<2>().norm() == 0 && d.z() >= 0)) {
          ++report_.rapid_plunges;
        } else if (last_.z() < top_ && d.head<2>().norm() > 0) {
          ++report_.rapid_plunges;
        }
      }
      last_ = point.tip;
    }
  }

 private:
  double top_;
  VerifyReport& report_;
  Vec3 last_ = Vec3::Zero();
};

// A verification; its steps in their order, each on what those before it found.
class PathVerification {
 public:
  PathVerification(const CompoundSurface& surface, const TriangleMesh& mesh, double deviation,
                   const CutterShape& cutter, const PlanLattice& lattice, const PathSource& path,
                   const VerifyOptions& options)
      : surface_(surface),
        mesh_(mesh),
        deviation_(deviation),
        cutter_(cutter),
        lattice_(lattice),
        path_(path),
        options_(options),
        joined_(kJoinedPart * (options.intol + options.outtol)),
        off_(joined_ + options.path_deviation),
        heights_(heights_over(surface, lattice, options.threads)),
        search_(mesh, cutter),
        swept_(cutter, lattice, heights_.z) {}

  Result<VerifyReport> run() {
    if (Status done = walk(); !done) return done.error();
    if (report_.points < 2) return input_error("the path has no move");
    if (Status done = tell_gouge(); !done) return done.error();
    const LatticeCheck check(surface_, cutter_, lattice_, heights_, search_, deviation_, options_);
    limit_ = check.limit();
    look_at_points(check);
    if (Status done = look_beside_walls(); !done) return done.error();
    look_at_cells(check);
    if (Status done = divide_open_cells(); !done) return done.error();
    tell_bound();
    return std::move(report_);
  }

 private:
  using Open = RowFindings::Open;

  Status walk();
  template <class Taker>
  Status walk_again(Taker& taker);
  Status tell_gouge();
  template <class Visit>
  void each_row(const Visit& visit) const;
  void look_at_points(const LatticeCheck& check);
  Status look_beside_walls();
  void look_at_cells(const LatticeCheck& check);
  [[nodiscard]] double enough(const Open& cell) const;
  void settle();
  void keep_worst(std::size_t most);
  Status divide_open_cells();
  void tell_bound();

  const CompoundSurface& surface_;
  const TriangleMesh& mesh_;
  double deviation_;
  CutterShape cutter_;
  PlanLattice lattice_;
  const PathSource& path_;
  const VerifyOptions& options_;
  double joined_, off_;  // off_: the moves looked at, from the path
  LatticeHeights heights_;
  GougeSearch search_;
  SweptHeights swept_;
  double limit_ = 0;
  std::vector<RowFindings> rows_;
  std::vector<Open> open_;  // cells that are not settled
  double bound_ = -1;       // of those that are
  std::size_t cells_ = 0, proven_ = 0;
  VerifyReport report_;
};

// Over the path for the first time: gouges into the mesh, what is left, the path's own figures.
Status PathVerification::walk() {
  const auto progress = [&](double part) {
    if (options_.progress) options_.progress(part);
  };
  double top = -std::numeric_limits<double>::infinity();
  for (const Vec3& p : mesh_.positions) top = std::fmax(top, p.z());
  MoveCounter counter(top, report_);
  std::size_t moves = 0;
  progress(0.1);
  return each_moves(
      path_, joined_,
      [&](std::span<const SweepMove> some) {
        search_.add(some, options_.threads);
        swept_.cut(some, options_.threads);
        moves += some.size();
        progress(0.1 + 0.7 * (1 - 1 / (1 + static_cast<double>(moves) / (4 * kMovesATime))));
      },
      [&](std::span<const ClPoint> points) { counter.look(points); });
}

template <class Taker>
Status PathVerification::walk_again(Taker& taker) {
  return each_moves(
      path_, joined_, [&](std::span<const SweepMove> some) { taker.add(some, options_.threads); },
      [](std::span<const ClPoint>) {});
}

Status PathVerification::tell_gouge() {
  const Gouge gouge = search_.deepest();
  // Rarely are there points deeper than the mesh knows: then the path is gone over again for them.
  Gouge on_surface;
  const TriangleMesh points =
      gouged_points(lattice_, heights_.z, swept_.heights(), gouge.depth + deviation_);
  if (!points.triangles.empty()) {
    GougeSearch again(points, cutter_);
    if (Status done = walk_again(again); !done) return done;
    on_surface = again.deepest();
  }
  const Gouge& worse = on_surface.depth > gouge.depth ? on_surface : gouge;
  report_.max_gouge = worse.depth;
  report_.max_gouge_at = worse.at;
  report_.bound =
      std::fmax(0, std::fmax(gouge.bound + deviation_, on_surface.bound) + off_ - worse.depth);
  return ok();
}

template <class Visit>
void PathVerification::each_row(const Visit& visit) const {
  parallel_blocks(lattice_.rows, 4, options_.threads, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t j = begin; j < end; ++j) visit(j);
  });
}

// The map, and what stays at the lattice's points.
void PathVerification::look_at_points(const LatticeCheck& check) {
  report_.columns = lattice_.columns;
  report_.rows = lattice_.rows;
  report_.spacing = std::fmax(lattice_.dx, lattice_.dy);
  report_.limit = limit_;
  report_.height.resize(lattice_.columns * lattice_.rows);
  report_.state.resize(report_.height.size());
  rows_.resize(lattice_.rows);
  each_row([&](std::size_t j) {
    rows_[j] = check.row(j, swept_, report_.height.data() + j * lattice_.columns,
                         report_.state.data() + j * lattice_.columns);
  });
  std::vector<float> cusps;
  double excess = -1;
  for (const RowFindings& row : rows_) {
    report_.uncut_area += row.uncut * lattice_.dx * lattice_.dy;
    report_.unreachable_area += row.unreachable * lattice_.dx * lattice_.dy;
    cusps.insert(cusps.end(), row.cusps.begin(), row.cusps.end());
    if (row.excess > excess) {
      excess = row.excess;
      report_.max_excess_at = row.excess_at;
    }
  }
  report_.max_excess = std::fmax(0, excess);
  report_.cusp_p50 = percentile(cusps, 0.5);
  report_.cusp_p99 = percentile(cusps, 0.99);
  report_.cusp_max = percentile(cusps, 1);
}

// Over the path again for points whose gouge is shallower than it is straight down.
Status PathVerification::look_beside_walls() {
  const std::vector<std::size_t> beside =
      points_beside_walls(lattice_, heights_.z, swept_.heights(), options_.intol);
  if (beside.empty()) return ok();
  std::vector<Vec3> places;
  places.reserve(beside.size());
  for (const std::size_t k : beside) {
    places.emplace_back(lattice_.x(k % lattice_.columns), lattice_.y(k / lattice_.columns),
                        heights_.z[k]);
  }
  PointDepths depths(cutter_, std::move(places));
  if (Status done = walk_again(depths); !done) return done;
  for (std::size_t k = 0; k < beside.size(); ++k) {
    float& height = report_.height[beside[k]];
    height = std::fmax(height, -static_cast<float>(depths.depths()[k]));
  }
  return ok();
}

void PathVerification::look_at_cells(const LatticeCheck& check) {
  const std::vector<float> dips =
      cell_dips(mesh_, deviation_, lattice_, heights_.z, limit_, options_.threads);
  each_row([&](std::size_t j) {
    check.cells(j, swept_, dips, report_, rows_[j], rows_[std::min(j + 1, lattice_.rows - 1)]);
  });
  for (const RowFindings& row : rows_) {
    open_.insert(open_.end(), row.open.begin(), row.open.end());
    bound_ = std::fmax(bound_, row.bound);
    cells_ += row.cells;
    proven_ += row.proven_cells;
  }
}

// Of what cannot be within the limit no more is asked than that it is known already; nor of
// anything, where far more than the limit stays somewhere: the path is not this cutter's, then.
double PathVerification::enough(const Open& cell) const {
  const bool clear = report_.max_excess > kClearExcess * limit_;
  return cell.over || clear ? std::fmax(limit_, report_.max_excess) : limit_;
}

void PathVerification::settle() {
  std::erase_if(open_, [&](const Open& cell) {
    if (cell.bound > enough(cell)) return false;
    bound_ = std::fmax(bound_, cell.bound);
    if (cell.bound <= limit_) ++proven_;
    return true;
  });
}

// The others are left with the bounds they have.
void PathVerification::keep_worst(std::size_t most) {
  if (open_.size() <= most) return;
  std::sort(open_.begin(), open_.end(), [](const Open& p, const Open& q) {
    return p.bound != q.bound ? p.bound > q.bound : p.cell < q.cell;
  });
  if (std::isfinite(open_[most].bound)) bound_ = std::fmax(bound_, open_[most].bound);
  open_.resize(most);
  std::sort(open_.begin(), open_.end(),
            [](const Open& p, const Open& q) { return p.cell < q.cell; });
}

// Cells that are not settled as a whole, at edges most of all, are divided; the worst of them, and
// the few that are still open with more of the moves.
Status PathVerification::divide_open_cells() {
  struct Look {
    int halvings;
    std::size_t most;
  };
  settle();
  for (const Look& look : {Look{1, kMostDivided}, Look{3, kMostDividedFinely}}) {
    keep_worst(look.most);
    if (open_.empty()) break;
    std::vector<std::size_t> numbers;
    std::vector<double> asked;
    for (const Open& cell : open_) {
      numbers.push_back(cell.cell);
      asked.push_back(enough(cell));
    }
    CellBounds divided(cutter_, lattice_, std::move(numbers), look.halvings);
    if (Status done = walk_again(divided); !done) return done;
    const std::vector<double> least = divided.bounds(mesh_, deviation_, asked, options_.threads);
    for (std::size_t k = 0; k < open_.size(); ++k) {
      open_[k].bound = std::fmin(open_[k].bound, least[k]);
    }
    settle();
  }
  return ok();
}

void PathVerification::tell_bound() {
  double bound = bound_;
  for (const Open& cell : open_) {
    if (std::isfinite(cell.bound)) bound = std::fmax(bound, cell.bound);
  }
  report_.excess_bound = std::fmax(0, bound + off_ - report_.max_excess);
  report_.proven_part = cells_ > 0 ? static_cast<double>(proven_) / static_cast<double>(cells_) : 0;
}

}  // namespace

Result<VerifyReport> verify_path(const CompoundSurface& surface, const TriangleMesh& mesh,
                                 double deviation, const ToolPath& path,
                                 const VerifyOptions& options) {
  return verify_path(
      surface, mesh, deviation,
      [&](const PathTaker& take) {
        take(path.points);
        return ok();
      },
      options);
}

Result<VerifyReport> verify_path(const CompoundSurface& surface, const TriangleMesh& mesh,
                                 double deviation, const PathSource& path,
                                 const VerifyOptions& options) {
  const Result<CutterShape> cutter = CutterShape::make(options.cutter);
  if (!cutter) return cutter.error();
  const Machining& machining = surface.program().machining;
  const double area =
      (machining.x_range[1] - machining.x_range[0]) * (machining.y_range[1] - machining.y_range[0]);
  const double spacing =
      options.spacing.value_or(std::fmax(cutter->radius() / 40, std::sqrt(area / kUsualPoints)));
  if (!(spacing > 0) || area / (spacing * spacing) > kMostPoints) {
    return input_error("a spacing of " + number_text(spacing) +
                       " gives more than 50 million points");
  }
  return PathVerification(surface, mesh, deviation, *cutter, lattice_over(machining, spacing), path,
                          options)
      .run();
}

}  // namespace diesink
