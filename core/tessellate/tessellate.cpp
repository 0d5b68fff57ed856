// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/tessellate.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

#include "core/grid/grid_array.h"
#include "core/parallel.h"
#include "core/tessellate/arc_samples.h"
#include "core/tessellate/arrangement.h"
#include "core/tessellate/assemble.h"
#include "core/tessellate/plain_grid.h"
#include "core/tessellate/region_mesh.h"
#include "core/tessellate/tessellate_scan.h"

namespace diesink {
namespace {

// Part of the tolerance that the chords of arcs may take; the faces beside them have the rest.
constexpr double kArcShare = 0.35;

// Ways to lay the cells before a part is refused.
constexpr int kVariants = 8;

double seconds_since(const std::chrono::steady_clock::time_point& start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// Of one tile of the domain. All cuts are products of the tile numbers and the domain alone, so
// that neighbours agree.
PlanBox tile_box(const PlanBox& domain, const TessellationOptions& options) {
  const auto cut = [](double a, double b, int k, int n) {
    return k == 0 ? a : k == n ? b : a + (b - a) * k / n;
  };
  return {cut(domain.x0, domain.x1, options.tile[0], options.tiles[0]),
          cut(domain.x0, domain.x1, options.tile[0] + 1, options.tiles[0]),
          cut(domain.y0, domain.y1, options.tile[1], options.tiles[1]),
          cut(domain.y0, domain.y1, options.tile[1] + 1, options.tiles[1])};
}

}  // namespace

Result<Tessellation> tessellate(const CompoundSurface& surface,
                                const TessellationOptions& options) {
  const Machining& m = surface.program().machining;
  const double tolerance = options.tolerance > 0 ? options.tolerance : m.tolerance;
  const PlanBox domain{m.x_range[0], m.x_range[1], m.y_range[0], m.y_range[1]};
  const PlanBox box = tile_box(domain, options);
  if (options.scheme == MeshScheme::kGrid && !options.creases) {
    return mesh_plain_grid(surface, box, options);
  }
  if (std::holds_alternative<MeshBase>(surface.program().base)) {
    if (options.scheme == MeshScheme::kAdaptive) return tessellate_scan(surface, box, options);
    return Error{ErrorCode::kUnsupported,
                 "edge points on the grid of a scanned base are not in this build; --mesh adaptive "
                 "and --mesh grid --no-creases are",
                 {surface.program().file}};
  }
  auto start = std::chrono::steady_clock::now();
  const auto tell = [&](double part) {
    if (options.progress) options.progress(part);
  };
  const bool grid = options.scheme == MeshScheme::kGrid;
  std::vector<double> xs, ys;
  if (grid) {
    xs = grid_lines(m.x_range[0], m.x_range[1], m.x_interval);
    ys = grid_lines(m.y_range[0], m.y_range[1], m.y_interval);
  }
  const double budget =
      tolerance * (1 - 1e-6) - 4 * surface.tie_tolerance();  // rounding of the vertices themselves
  SamplingOptions sampling;
  sampling.sag = kArcShare * budget;
  sampling.tolerance = budget;
  sampling.shortest = std::fmax(0.5 * tolerance, 1e-9 * surface.size());
  RegionOptions region_options;
  region_options.tolerance = budget;
  region_options.shortest = sampling.shortest;
  region_options.threads = options.threads;
  if (grid) {
    region_options.grid_x = sampling.grid_x = &xs;
    region_options.grid_y = sampling.grid_y = &ys;
  }

  // Where cells happen to lie decides how what is finer than the least cell is joined; what cannot
  // be meshed for that reason alone is found anew with cells that lie elsewhere.
  std::optional<Arrangement> arrangement;
  std::optional<ArcSamples> samples;
  std::vector<RegionMesh> regions;
  double evaluate = 0;
  for (int variant = 0;; ++variant) {
    ArrangementOptions arrangement_options;
    arrangement_options.tolerance = tolerance;
    arrangement_options.variant = variant;
    Result<Arrangement> found = arrange(surface, box, arrangement_options);
    if (!found) return found.error();
    arrangement.emplace(std::move(*found));
    evaluate = seconds_since(start);
    tell(0.2);
    samples.emplace(surface.impl(), *arrangement, sampling);
    {
      const ProgressSpan span(options.progress, 0.2, 0.4);
      samples->sample_all(options.threads);
    }
    tell(0.4);
    Result<std::vector<RegionMesh>> meshed = [&] {
      const ProgressSpan span(options.progress, 0.4, 0.9);
      return mesh_regions(surface.impl(), *arrangement, *samples, region_options);
    }();
    if (meshed) {
      regions = std::move(*meshed);
      break;
    }
    if (variant + 1 == kVariants) return meshed.error();
  }
  tell(0.9);

  Result<Tessellation> made = assemble(surface, *arrangement, *samples, regions, options);
  if (!made) return made.error();
  TessellationReport& report = made->report;
  report.tolerance = tolerance;
  report.uncertified_area = arrangement->uncertified_area;
  report.certified_deviation = samples->largest_deviation;
  for (const RegionMesh& r : regions) {
    report.uncertified_area += r.unproven_area;
    report.certified_deviation = std::fmax(report.certified_deviation, r.largest_deviation);
    const std::string name = surface.element_name(r.label);
    for (ElementReport& e : report.elements) {
      if (e.name == name) e.max_deviation = std::fmax(e.max_deviation, r.largest_deviation);
    }
  }
  report.uncertified_area += samples->unproven_length * 2 * samples->largest_deviation;
  report.seconds_evaluate = evaluate;
  report.seconds_tessellate = seconds_since(start) - evaluate;
  tell(1);
  return made;
}

}  // namespace diesink
