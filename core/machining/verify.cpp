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
  const auto progress = [&](double part) {
    if (options.progress) options.progress(part);
  };
  const PlanLattice lattice = lattice_over(machining, spacing);
  const LatticeHeights heights = heights_over(surface, lattice, options.threads);
  VerifyReport report;
  double top = -std::numeric_limits<double>::infinity();
  for (const Vec3& p : mesh.positions) top = std::fmax(top, p.z());

  const double joined = kJoinedPart * (options.intol + options.outtol);
  const double off = joined + options.path_deviation;  // the moves looked at, from the path
  GougeSearch search(mesh, *cutter);
  SweptHeights swept(*cutter, lattice, heights.z);
  MoveCounter counter(top, report);
  std::size_t moves = 0;
  progress(0.1);
  Status walked = each_moves(
      path, joined,
      [&](std::span<const SweepMove> some) {
        search.add(some, options.threads);
        swept.cut(some, options.threads);
        moves += some.size();
        progress(0.1 + 0.7 * (1 - 1 / (1 + static_cast<double>(moves) / (4 * kMovesATime))));
      },
      [&](std::span<const ClPoint> points) { counter.look(points); });
  if (!walked) return walked.error();
  if (report.points < 2) return input_error("the path has no move");
  const Gouge gouge = search.deepest();
  // Rarely are there points deeper than the mesh knows: then the path is gone over again for them.
  Gouge on_surface;
  const TriangleMesh points =
      gouged_points(lattice, heights.z, swept.heights(), gouge.depth + deviation);
  if (!points.triangles.empty()) {
    GougeSearch again(points, *cutter);
    walked = each_moves(
        path, joined, [&](std::span<const SweepMove> some) { again.add(some, options.threads); },
        [](std::span<const ClPoint>) {});
    if (!walked) return walked.error();
    on_surface = again.deepest();
  }
  const Gouge& worse = on_surface.depth > gouge.depth ? on_surface : gouge;
  report.max_gouge = worse.depth;
  report.max_gouge_at = worse.at;
  report.bound =
      std::fmax(0, std::fmax(gouge.bound + deviation, on_surface.bound) + off - worse.depth);

  const std::vector<std::size_t> beside =
      points_beside_walls(lattice, heights.z, swept.heights(), options.intol);
  std::vector<Vec3> places;
  for (const std::size_t k : beside) {
    places.emplace_back(lattice.x(k % lattice.columns), lattice.y(k / lattice.columns),
                        heights.z[k]);
  }
  PointDepths depths(*cutter, std::move(places));
  if (!beside.empty()) {
    walked = each_moves(
        path, joined, [&](std::span<const SweepMove> some) { depths.add(some, options.threads); },
        [](std::span<const ClPoint>) {});
    if (!walked) return walked.error();
  }

  const LatticeCheck check(surface, *cutter, lattice, heights, search, deviation, options);
  report.columns = lattice.columns;
  report.rows = lattice.rows;
  report.spacing = std::fmax(lattice.dx, lattice.dy);
  report.limit = check.limit();
  report.height.resize(lattice.columns * lattice.rows);
  report.state.resize(report.height.size());
  std::vector<RowFindings> rows(lattice.rows);
  const auto each_row = [&](const auto& visit) {
    parallel_blocks(lattice.rows, 4, options.threads, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t j = begin; j < end; ++j) visit(j);
    });
  };
  each_row([&](std::size_t j) {
    rows[j] = check.row(j, swept, report.height.data() + j * lattice.columns,
                        report.state.data() + j * lattice.columns);
  });
  for (std::size_t k = 0; k < beside.size(); ++k) {
    float& height = report.height[beside[k]];
    height = std::fmax(height, -static_cast<float>(depths.depths()[k]));
  }
  std::vector<float> cusps;
  double excess = -1;
  for (const RowFindings& row : rows) {
    report.uncut_area += row.uncut * lattice.dx * lattice.dy;
    report.unreachable_area += row.unreachable * lattice.dx * lattice.dy;
    cusps.insert(cusps.end(), row.cusps.begin(), row.cusps.end());
    if (row.excess > excess) {
      excess = row.excess;
      report.max_excess_at = row.excess_at;
    }
  }
  report.max_excess = std::fmax(0, excess);
  const std::vector<float> dips =
      cell_dips(mesh, deviation, lattice, heights.z, check.limit(), options.threads);
  each_row([&](std::size_t j) {
    check.cells(j, swept, dips, report, rows[j], rows[std::min(j + 1, lattice.rows - 1)]);
  });
  // Cells that are not settled as a whole, at edges most of all, are divided; the worst of them,
  // and the few that are still open with more of the moves.
  std::vector<RowFindings::Open> open;
  double bound = -1;
  std::size_t cells = 0, proven = 0;
  for (const RowFindings& row : rows) {
    open.insert(open.end(), row.open.begin(), row.open.end());
    bound = std::fmax(bound, row.bound);
    cells += row.cells;
    proven += row.proven_cells;
  }
  // Of what cannot be within the limit no more is asked than that it is known already; nor of
  // anything, where far more than the limit stays somewhere: the path is not this cutter's, then.
  const bool clear = report.max_excess > kClearExcess * check.limit();
  const auto enough = [&](const RowFindings::Open& one) {
    return one.over || clear ? std::fmax(check.limit(), report.max_excess) : check.limit();
  };
  const auto settle = [&] {
    std::erase_if(open, [&](const RowFindings::Open& one) {
      if (one.bound > enough(one)) return false;
      bound = std::fmax(bound, one.bound);
      if (one.bound <= check.limit()) ++proven;
      return true;
    });
  };
  settle();
  struct Look {
    int halvings;
    std::size_t most;
  };
  for (const Look& look : {Look{1, kMostDivided}, Look{3, kMostDividedFinely}}) {
    if (open.size() > look.most) {
      std::sort(open.begin(), open.end(), [](const auto& p, const auto& q) {
        return p.bound != q.bound ? p.bound > q.bound : p.cell < q.cell;
      });
      if (std::isfinite(open[look.most].bound)) bound = std::fmax(bound, open[look.most].bound);
      open.resize(look.most);
      std::sort(open.begin(), open.end(),
                [](const auto& p, const auto& q) { return p.cell < q.cell; });
    }
    if (open.empty()) break;
    std::vector<std::size_t> numbers;
    std::vector<double> asked;
    for (const RowFindings::Open& one : open) {
      numbers.push_back(one.cell);
      asked.push_back(enough(one));
    }
    CellBounds divided(*cutter, lattice, std::move(numbers), look.halvings);
    walked = each_moves(
        path, joined, [&](std::span<const SweepMove> some) { divided.add(some, options.threads); },
        [](std::span<const ClPoint>) {});
    if (!walked) return walked.error();
    const std::vector<double> least = divided.bounds(mesh, deviation, asked, options.threads);
    for (std::size_t k = 0; k < open.size(); ++k) {
      open[k].bound = std::fmin(open[k].bound, least[k]);
    }
    settle();
  }
  for (const RowFindings::Open& one : open) {
    if (std::isfinite(one.bound)) bound = std::fmax(bound, one.bound);
  }
  report.excess_bound = std::fmax(0, bound + off - report.max_excess);
  report.proven_part = cells > 0 ? static_cast<double>(proven) / static_cast<double>(cells) : 0;
  report.cusp_p50 = percentile(cusps, 0.5);
  report.cusp_p99 = percentile(cusps, 0.99);
  report.cusp_max = percentile(cusps, 1);
  return report;
}

}  // namespace diesink
