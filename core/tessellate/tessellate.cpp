// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/tessellate.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <string>
#include <unordered_map>

#include "core/grid/grid_array.h"
#include "core/number.h"
#include "core/parallel.h"
#include "core/tessellate/arc_samples.h"
#include "core/tessellate/arrangement.h"
#include "core/tessellate/assemble.h"
#include "core/tessellate/home.h"
#include "core/tessellate/last_check.h"
#include "core/tessellate/mesh_report.h"
#include "core/tessellate/plain_grid.h"
#include "core/tessellate/region_mesh.h"
#include "core/tessellate/seam.h"
#include "core/tessellate/tessellate_scan.h"
#include "core/tessellate/untangle.h"

namespace diesink {
namespace {

// Part of the tolerance that the chords of arcs may take beside curved faces. The whole would be
// proven too (region_mesh.cpp), but chords of a circle with it are longer than the edges of a
// sphere beside them may be, and would be split.
constexpr double kArcShare = 0.75;
// Of seams, which no round of refinement splits, and of the arcs of tiles, which end at them: less,
// so that the triangles beside them have room.
constexpr double kSeamShare = 0.35;
// And between planes.
constexpr double kFlatArcShare = 0.96;

// Ties: what is left of a finer tolerance when vertices have rounded is nothing to refine to.
constexpr double kFinest = 16;

PlanBox tile_box(const TileCuts& cuts, const std::array<int, 2>& tile) {
  const auto i = static_cast<std::size_t>(tile[0]), j = static_cast<std::size_t>(tile[1]);
  return {cuts.x[i], cuts.x[i + 1], cuts.y[j], cuts.y[j + 1]};
}

// The seams with the tiles beside it: bottom, right, top, left.
std::array<std::optional<Seam>, 4> seams_of(const CompoundSurface& surface, const PlanBox& box,
                                            const TessellationOptions& options, SeamOptions seam,
                                            const std::vector<double>* grid_x,
                                            const std::vector<double>* grid_y) {
  std::array<std::optional<Seam>, 4> seams;
  const TileSides sides(box, options, border_inset(surface.impl()));
  for (std::size_t side = 0; side < 4; ++side) {
    if (!sides.cut[side]) continue;
    const int axis = TileSides::axis(side);
    seam.grid = axis == 0 ? grid_y : grid_x;
    seams[side] =
        make_seam(surface.impl(), axis, sides.at[side], sides.from[side], sides.to[side], seam);
  }
  return seams;
}

// Below everything the surface can be made of: the same for all tiles.
double common_floor(const CompoundSurface& surface, const PlanBox& domain) {
  const CompoundSurface::Impl& impl = surface.impl();
  double lowest = HUGE_VAL;
  for (const CompoundStep& step : impl.steps) {
    if (step.kind != BooleanStep::Kind::kTerm) continue;
    if (step.solid >= 0) {
      lowest = std::fmin(lowest, impl.bodies[static_cast<std::size_t>(step.solid)].z_low());
      continue;
    }
    const CellBox box = CellBox::of(domain);
    FaceOver face;
    FunctionList outline;
    if (base_over(impl, step, box, face, outline) == Coverage::kOutside) continue;
    lowest = std::fmin(
        lowest, face.c + face.lo - std::fabs(face.gx) * box.hx - std::fabs(face.gy) * box.hy);
  }
  return lowest - 0.1 * std::fmax(domain.x1 - domain.x0, domain.y1 - domain.y0);
}

// What of the plan is to be meshed, in the coordinates of the surface.
struct Plan {
  PlanBox domain, box;  // the whole, and the tile or the whole again
  double tolerance = 0;
  double least_altitude = 0;
  double largest_coordinate = 0;  // where the mesh will be moved to; 0: it stays
  std::vector<double> xs, ys;     // lines of the grid scheme
};

// The mesh but for its last check.
Result<Tessellation> mesh_faces(const CompoundSurface& surface, const Plan& plan,
                                const TessellationOptions& options) {
  const double tolerance = plan.tolerance;
  const bool tiled = options.tiles != std::array{1, 1};
  auto start = std::chrono::steady_clock::now();
  const auto tell = [&](double part) {
    if (options.progress) options.progress(part);
  };
  const bool grid = options.scheme == MeshScheme::kGrid;
  // Less the rounding of the vertices themselves, here and where they are moved to.
  const double budget = tolerance * (1 - 1e-6) - 4 * surface.tie_tolerance() -
                        std::ldexp(plan.largest_coordinate, -51);
  SamplingOptions sampling;
  sampling.sag = (tiled ? kSeamShare : kArcShare) * budget;
  sampling.flat_sag = (tiled ? kSeamShare : kFlatArcShare) * budget;
  sampling.tolerance = budget;
  sampling.shortest = std::fmax(0.5 * tolerance, 1e-9 * surface.size());
  sampling.unseen = kUnseen * tolerance;
  RegionOptions region_options;
  region_options.tolerance = budget;
  region_options.shortest = sampling.shortest;
  region_options.least_altitude = plan.least_altitude;
  region_options.largest_coordinate = plan.largest_coordinate;
  region_options.threads = options.threads;
  region_options.floor = options.solid;
  region_options.crossings = options.budget.crossings;
  if (grid) {
    region_options.grid_x = sampling.grid_x = &plan.xs;
    region_options.grid_y = sampling.grid_y = &plan.ys;
  }

  SeamOptions seam_options;
  seam_options.domain = plan.domain;
  seam_options.tolerance = budget;
  seam_options.sag = kSeamShare * budget;
  seam_options.shortest = sampling.shortest;
  seam_options.search = {
      flat_height(surface.impl(), tolerance),
      least_cell(std::fmax(plan.domain.x1 - plan.domain.x0, plan.domain.y1 - plan.domain.y0),
                 tolerance),
      kUnseen * tolerance, 0.25 * tolerance, options.budget.pieces};
  const std::array<std::optional<Seam>, 4> seams = seams_of(
      surface, plan.box, options, seam_options, region_options.grid_x, region_options.grid_y);

  // Where cells happen to lie decides how what is finer than the least cell is joined; what cannot
  // be meshed for that reason alone is found anew with cells that lie elsewhere.
  std::optional<Arrangement> arrangement;
  std::optional<ArcSamples> samples;
  std::vector<RegionMesh> regions;
  double evaluate = 0;
  const auto mesh = [&] {
    const ProgressSpan span(options.progress, 0.4, 0.9);
    return mesh_regions(surface.impl(), *arrangement, *samples, region_options);
  };
  for (int variant = 0;; ++variant) {
    ArrangementOptions arrangement_options;
    arrangement_options.largest_coordinate = plan.largest_coordinate;
    arrangement_options.tolerance = tolerance;
    arrangement_options.threads = options.threads;
    arrangement_options.variant = variant;
    arrangement_options.budget = options.budget;
    for (std::size_t side = 0; side < 4; ++side) {
      if (seams[side]) arrangement_options.seams[side] = &*seams[side];
    }
    const bool last = variant + 1 >= options.budget.variants;
    Result<Arrangement> found = arrange(surface, plan.box, arrangement_options);
    if (!found && tiled && found.error().code == ErrorCode::kInput) return empty_tile(plan.box);
    if (!found) return found.error();
    if (!found->keeps_seams) {
      if (!last) continue;
      return Error{ErrorCode::kInput,
                   "a cut between tiles runs along what cannot be told apart at the least distance",
                   {surface.program().file}};
    }
    const bool disorder = found->disorder > 0;
    if (disorder && !last) continue;
    arrangement.emplace(std::move(*found));
    evaluate = seconds_since(start);
    tell(0.2);
    samples.emplace(surface.impl(), *arrangement, sampling);
    {
      const ProgressSpan span(options.progress, 0.2, 0.4);
      samples->sample_all(options.threads);
    }
    tell(0.4);
    region_options.to_the_end = last;
    Result<std::vector<RegionMesh>> meshed = mesh();
    if (last && (!meshed || disorder)) {
      std::optional<Arrangement> straight =
          untangle(surface.impl(), *arrangement, *samples, plan.largest_coordinate);
      if (straight) {
        samples.reset();
        arrangement.emplace(std::move(*straight));
        samples.emplace(surface.impl(), *arrangement, sampling);
        samples->sample_all(options.threads);
        meshed = mesh();
      }
    }
    if (meshed) {
      regions = std::move(*meshed);
      break;
    }
    if (last) return meshed.error();
  }
  tell(0.9);

  Result<Tessellation> made = assemble(surface, *arrangement, *samples, regions, options);
  if (!made) return made.error();
  TessellationReport& report = made->report;
  report.tolerance = tolerance;
  report.certified_deviation = samples->largest_deviation;
  std::unordered_map<std::string, ElementReport*> by_name;
  for (ElementReport& e : report.elements) by_name.emplace(e.name, &e);
  for (const RegionMesh& r : regions) {
    report.certified_deviation = std::fmax(report.certified_deviation, r.largest_deviation);
    const auto element = by_name.find(surface.element_name(r.label));
    if (element == by_name.end()) continue;
    double& most = element->second->max_deviation;
    most = std::fmax(most, r.largest_deviation);
  }
  add_doubts(surface, *arrangement, *samples, regions, samples->largest_deviation, report);
  if (grid) {  // keeps its nodes, not the tolerance: no place of it is doubtful
    report.doubts.clear();
    report.doubt_count = 0;
  }
  report.seconds_evaluate = evaluate;
  report.seconds_tessellate = seconds_since(start) - evaluate;
  return made;
}

// Takes a finished mesh back to where the program has it.
void move_back(const CompoundSurface& given, const Vec2& way, Tessellation& made) {
  const Vec3 step(way.x(), way.y(), 0);
  for (Vec3& p : made.mesh.positions) p -= step;
  TessellationReport& report = made.report;
  // Counted again: vertices have rounded to their coordinates there.
  std::vector<ElementReport> before = std::move(report.elements);
  fill_report(given, made, report.bounds[0].z(), report);
  for (std::size_t e = 0; e < before.size(); ++e)
    report.elements[e].max_deviation = before[e].max_deviation;
  for (MeshDoubt& doubt : report.doubts) doubt.place -= step;
  for (std::size_t k = 0; k < 4; ++k) report.domain[k] -= way[static_cast<Eigen::Index>(k / 2)];
}

}  // namespace

Result<Tessellation> tessellate(const CompoundSurface& given, const TessellationOptions& asked) {
  const Machining& m = given.program().machining;
  const double tolerance = asked.tolerance > 0 ? asked.tolerance : m.tolerance;
  const PlanBox domain{m.x_range[0], m.x_range[1], m.y_range[0], m.y_range[1]};
  if (const double finest = kFinest * given.tie_tolerance(); tolerance < finest) {
    return Error{ErrorCode::kInput,
                 "the tolerance is finer than coordinates as large as these can hold; ask for " +
                     number_text(std::pow(10, std::ceil(std::log10(finest)))) + " or more",
                 {given.program().file}};
  }
  const bool tiled = asked.tiles != std::array{1, 1};
  TessellationOptions options = asked;
  if (tiled && options.solid && !options.floor) options.floor = common_floor(given, domain);
  const PlanBox box =
      !tiled ? domain
             : tile_box(options.cuts != nullptr ? *options.cuts
                                                : tile_cuts(given, options.tiles, tolerance),
                        options.tile);
  if (options.scheme == MeshScheme::kGrid && !options.creases) {
    return mesh_plain_grid(given, box, options);
  }
  std::optional<CompoundSurface> seen;  // a scan's, the same for all tiles
  if (std::holds_alternative<MeshBase>(given.program().base)) {
    if (options.scheme == MeshScheme::kAdaptive) return tessellate_scan(given, box, options);
    Result<CompoundSurface> made = seen_surface(given, domain, tolerance, options.threads);
    if (!made) return made.error();
    seen.emplace(std::move(*made));
  }
  const Home home(given);
  Plan plan;
  plan.domain = home.there(domain);
  plan.box = home.there(box);
  plan.tolerance = tolerance;
  plan.least_altitude = least_altitude(given);
  if (home.is_moved()) plan.largest_coordinate = given.size();
  if (options.scheme == MeshScheme::kGrid) {
    plan.xs = grid_lines(m.x_range[0], m.x_range[1], m.x_interval);
    plan.ys = grid_lines(m.y_range[0], m.y_range[1], m.y_interval);
    for (double& x : plan.xs) x += home.way().x();
    for (double& y : plan.ys) y += home.way().y();
  }
  Result<Tessellation> made = mesh_faces(seen ? *seen : home.surface(), plan, options);
  if (!made) return made;
  const auto start = std::chrono::steady_clock::now();
  if (home.is_moved()) move_back(given, home.way(), *made);
  last_check(seen ? *seen : given, options.threads, *made);
  made->report.seconds_tessellate += seconds_since(start);
  if (options.progress) options.progress(1);
  return made;
}

}  // namespace diesink
