// SPDX-License-Identifier: Apache-2.0
#include "core/machining/verify.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/machining/gouge_search.h"
#include "core/machining/height_pyramid.h"
#include "core/machining/swept_heights.h"
#include "core/number.h"
#include "core/parallel.h"

namespace diesink {
namespace {

constexpr double kMostPoints = 5e7;  // of the lattice
constexpr double kUsualPoints = 4e6;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

Error input_error(std::string message) { return {ErrorCode::kInput, std::move(message), {}}; }

std::vector<SweepMove> moves_of(const ToolPath& path) {
  std::vector<SweepMove> moves;
  moves.reserve(path.points.size());
  for (std::size_t k = 1; k < path.points.size(); ++k) {
    moves.push_back({path.points[k - 1].tip, path.points[k].tip});
  }
  return moves;
}

// The surface over a lattice: heights (NaN in holes) and normals.
struct Heights {
  std::vector<double> z;
  std::vector<float> nx, ny, nz;
};

Heights evaluate(const CompoundSurface& surface, const PlanLattice& lattice, int threads) {
  Heights out;
  const std::size_t count = lattice.columns * lattice.rows;
  out.z.resize(count);
  out.nx.resize(count);
  out.ny.resize(count);
  out.nz.resize(count);
  std::vector<double> xs(lattice.columns);
  for (std::size_t i = 0; i < xs.size(); ++i) xs[i] = lattice.x(i);
  parallel_blocks(lattice.rows, 8, threads, [&](std::size_t begin, std::size_t end, int) {
    std::vector<double> nx(xs.size()), ny(xs.size()), nz(xs.size());
    std::vector<Label> label(xs.size());
    for (std::size_t j = begin; j < end; ++j) {
      const std::size_t at = j * xs.size();
      surface.row(lattice.y(j), xs,
                  {out.z.data() + at, nx.data(), ny.data(), nz.data(), label.data()});
      for (std::size_t i = 0; i < xs.size(); ++i) {
        out.nx[at + i] = static_cast<float>(nx[i]);
        out.ny[at + i] = static_cast<float>(ny[i]);
        out.nz[at + i] = static_cast<float>(nz[i]);
        if (label[i] == kNoLabel) out.z[at + i] = kNaN;
      }
    }
  });
  return out;
}

// What one row of the lattice adds to the report.
struct RowFindings {
  double excess = -1, gouge = 0, bound = 0;
  Vec3 excess_at = Vec3::Zero(), gouge_at = Vec3::Zero();
  std::size_t uncut = 0, unreachable = 0;
  std::vector<float> cusps;
};

class LatticeCheck {
 public:
  LatticeCheck(const CompoundSurface& surface, const CutterShape& cutter,
               const PlanLattice& lattice, const VerifyOptions& options)
      : cutter_(cutter),
        lattice_(lattice),
        limit_(options.outtol + options.cusp.value_or(0)),
        slack_(options.outtol),
        z_(evaluate(surface, lattice, options.threads)),
        pyramid_(wide(lattice, cutter), wide_heights(surface, options.threads)) {}

  RowFindings row(std::size_t j, const std::vector<double>& swept, float* height,
                  CutState* state) const {
    RowFindings out;
    for (std::size_t i = 0; i < lattice_.columns; ++i) {
      const std::size_t k = j * lattice_.columns + i;
      const double z = z_.z[k];
      height[i] = 0;
      if (std::isnan(z)) {
        state[i] = CutState::kNoSurface;
        continue;
      }
      const Vec3 n(static_cast<double>(z_.nx[k]), static_cast<double>(z_.ny[k]),
                   static_cast<double>(z_.nz[k]));
      const bool cut = swept[k] < std::numeric_limits<double>::infinity();
      const double stays = cut ? (swept[k] - z) * n.z() : 0;
      if ((!cut || stays > limit_) && !reachable(i, j, z, n)) {
        state[i] = CutState::kUnreachable;
        ++out.unreachable;
        continue;
      }
      if (!cut) {
        state[i] = CutState::kUncut;
        ++out.uncut;
        continue;
      }
      state[i] = CutState::kCut;
      height[i] = static_cast<float>(stays);
      if (stays > limit_)
        ++out.uncut;
      else
        out.cusps.push_back(static_cast<float>(std::fmax(stays, 0)));
      if (stays > out.excess) {
        out.excess = stays;
        out.excess_at = Vec3(lattice_.x(i), lattice_.y(j), z);
      }
    }
    return out;
  }

  [[nodiscard]] double limit() const { return limit_; }
  [[nodiscard]] const std::vector<double>& z() const { return z_.z; }

 private:
  // The lattice carried on by the cutter's diameter: material outside the domain holds it off too.
  static PlanLattice wide(const PlanLattice& lattice, const CutterShape& cutter) {
    PlanLattice out = lattice;
    const auto more = [&](double step) {
      return static_cast<std::size_t>(std::ceil(2 * cutter.radius() / step));
    };
    const std::size_t i = more(lattice.dx), j = more(lattice.dy);
    out.x0 -= static_cast<double>(i) * lattice.dx;
    out.y0 -= static_cast<double>(j) * lattice.dy;
    out.columns += 2 * i;
    out.rows += 2 * j;
    return out;
  }
  std::vector<double> wide_heights(const CompoundSurface& surface, int threads) const {
    return evaluate(surface, wide(lattice_, cutter_), threads).z;
  }

  // Equation (6) puts the cutter on the point; it must clear everything around and stand in the
  // domain.
  [[nodiscard]] bool reachable(std::size_t i, std::size_t j, double z, const Vec3& n) const {
    const double flat = n.head<2>().norm();
    const double shift = cutter_.corner() + (flat > 1e-9 ? cutter_.flat() / flat : 0);
    const Vec3 tip(lattice_.x(i) + shift * n.x(), lattice_.y(j) + shift * n.y(),
                   z + cutter_.corner() * (n.z() - 1));
    const double hair = 1e-9 * cutter_.radius();
    if (tip.x() < lattice_.x0 - hair || tip.y() < lattice_.y0 - hair ||
        tip.x() > lattice_.x(lattice_.columns - 1) + hair ||
        tip.y() > lattice_.y(lattice_.rows - 1) + hair) {
      return false;
    }
    return pyramid_.clears(cutter_, tip, slack_);
  }

  CutterShape cutter_;
  PlanLattice lattice_;
  double limit_, slack_;
  Heights z_;
  HeightPyramid pyramid_;
};

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

// Lattice points of the true surface that lie inside a swept volume, by their own depth.
Gouge surface_gouge(const CutterShape& cutter, const std::vector<SweepMove>& moves,
                    const PlanLattice& lattice, const std::vector<double>& z,
                    const std::vector<double>& swept, double floor, int threads) {
  TriangleMesh points;
  for (std::size_t k = 0; k < z.size(); ++k) {
    if (!(z[k] - swept[k] > floor)) continue;
    const auto at = static_cast<std::uint32_t>(points.positions.size());
    points.positions.emplace_back(lattice.x(k % lattice.columns), lattice.y(k / lattice.columns),
                                  z[k]);
    points.triangles.push_back({at, at, at});
  }
  if (points.triangles.empty()) return {};
  return GougeSearch(points, cutter).deepest(moves, threads);
}

}  // namespace

Result<VerifyReport> verify_path(const CompoundSurface& surface, const TriangleMesh& mesh,
                                 double deviation, const ToolPath& path,
                                 const VerifyOptions& options) {
  const Result<CutterShape> cutter = CutterShape::make(options.cutter);
  if (!cutter) return cutter.error();
  if (path.points.size() < 2) return input_error("the path has no move");
  const Machining& machining = surface.program().machining;
  const double area =
      (machining.x_range[1] - machining.x_range[0]) * (machining.y_range[1] - machining.y_range[0]);
  const double spacing =
      options.spacing.value_or(std::fmax(cutter->radius() / 20, std::sqrt(area / kUsualPoints)));
  if (!(spacing > 0) || area / (spacing * spacing) > kMostPoints) {
    return input_error("a spacing of " + number_text(spacing) +
                       " gives more than 50 million points");
  }
  const PlanLattice lattice = lattice_over(machining, spacing);
  const std::vector<SweepMove> moves = moves_of(path);
  VerifyReport report;
  report.points = path.points.size();
  double top = -std::numeric_limits<double>::infinity();
  for (const Vec3& p : mesh.positions) top = std::fmax(top, p.z());
  for (std::size_t k = 0; k < moves.size(); ++k) {
    const Vec3 d = moves[k].to - moves[k].from;
    if (path.points[k + 1].motion == Motion::kFeed) {
      report.length += d.norm();
    } else if (moves[k].to.z() < top && !(d.head<2>().norm() == 0 && d.z() >= 0)) {
      ++report.rapid_plunges;
    }
  }

  const Gouge gouge = [&] {
    const ProgressSpan span(options.progress, 0, 0.5);
    return GougeSearch(mesh, *cutter).deepest(moves, options.threads);
  }();
  const std::vector<double> swept = [&] {
    const ProgressSpan span(options.progress, 0.5, 0.8);
    return swept_heights(*cutter, moves, lattice, options.threads);
  }();
  const ProgressSpan span(options.progress, 0.8, 1);
  const LatticeCheck check(surface, *cutter, lattice, options);
  const Gouge on_surface = surface_gouge(*cutter, moves, lattice, check.z(), swept,
                                         gouge.depth + deviation, options.threads);
  const Gouge& worse = on_surface.depth > gouge.depth ? on_surface : gouge;
  report.max_gouge = worse.depth;
  report.max_gouge_at = worse.at;
  report.bound = std::fmax(0, std::fmax(gouge.bound + deviation, on_surface.bound) - worse.depth);

  report.columns = lattice.columns;
  report.rows = lattice.rows;
  report.spacing = std::fmax(lattice.dx, lattice.dy);
  report.limit = check.limit();
  report.height.resize(lattice.columns * lattice.rows);
  report.state.resize(report.height.size());
  std::vector<RowFindings> rows(lattice.rows);
  parallel_blocks(lattice.rows, 4, options.threads, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t j = begin; j < end; ++j) {
      rows[j] = check.row(j, swept, report.height.data() + j * lattice.columns,
                          report.state.data() + j * lattice.columns);
    }
  });
  std::vector<float> cusps;
  double excess = -1;
  for (const RowFindings& row : rows) {
    report.uncut_area += static_cast<double>(row.uncut) * lattice.dx * lattice.dy;
    report.unreachable_area += static_cast<double>(row.unreachable) * lattice.dx * lattice.dy;
    cusps.insert(cusps.end(), row.cusps.begin(), row.cusps.end());
    if (row.excess > excess) {
      excess = row.excess;
      report.max_excess_at = row.excess_at;
    }
  }
  report.max_excess = std::fmax(0, excess);
  report.cusp_p50 = percentile(cusps, 0.5);
  report.cusp_p99 = percentile(cusps, 0.99);
  report.cusp_max = percentile(cusps, 1);
  return report;
}

}  // namespace diesink
