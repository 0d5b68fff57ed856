// Tool paths: the drop on a lattice and at single points, planning, verification.
// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>

#include <cmath>
#include <exception>

#include "bench/bench_parts.h"
#include "core/machining/drop.h"
#include "core/machining/lattice_drop.h"
#include "core/machining/tool_path_plan.h"
#include "core/machining/verify.h"
#include "core/tessellate/tessellate.h"

namespace diesink {
namespace {

TriangleMesh mesh_of(const CompoundSurface& surface, double tolerance) {
  TessellationOptions options;
  options.tolerance = tolerance;
  try {
    Result<Tessellation> made = tessellate(surface, options);
    if (made) return std::move(made->mesh);
    std::fprintf(stderr, "%s\n", to_text(made.error()).c_str());
  } catch (const std::exception& failure) {
    std::fprintf(stderr, "tessellate: %s\n", failure.what());
  }
  return {};  // its benchmarks are left out, the others run
}

bool left_out(benchmark::State& state, const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) state.SkipWithError("the part could not be tessellated");
  return mesh.triangles.empty();
}

const CompoundSurface& solids400() {
  static const CompoundSurface surface = bench::generated("solids400");
  return surface;
}
const TriangleMesh& solids400_mesh() {
  static const TriangleMesh mesh = mesh_of(solids400(), 0.05);
  return mesh;
}

PathOptions fig6_options() {
  PathOptions options;
  options.cutter = {6, 3};
  options.intol = options.outtol = 0.02;
  options.cusp = 0.01;
  return options;
}

// The offset surface of the 400-solid part and a ball of 12.
void offset_solids400(benchmark::State& state) {
  const TriangleMesh& mesh = solids400_mesh();
  if (left_out(state, mesh)) return;
  const CutterShape cutter = *CutterShape::make({12, 6});
  for (auto _ : state) benchmark::DoNotOptimize(OffsetSurface(mesh, cutter, 0).piece_count());
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(mesh.triangles.size()));
}
BENCHMARK(offset_solids400)->UseRealTime();

// Points of the lattice of the passes, dropped exactly. Argument: spacing in hundredths, threads.
void drop_lattice_solids400(benchmark::State& state) {
  if (left_out(state, solids400_mesh())) return;
  static const OffsetSurface offset(solids400_mesh(), *CutterShape::make({12, 6}), 0);
  const Machining& m = solids400().program().machining;
  const double spacing = static_cast<double>(state.range(0)) / 100;
  const auto columns = static_cast<std::size_t>((m.x_range[1] - m.x_range[0]) / spacing) + 1;
  std::vector<double> ys;
  for (double y = m.y_range[0]; y <= m.y_range[1]; y += spacing) ys.push_back(y);
  std::vector<double> heights(columns * ys.size());
  for (auto _ : state) {
    drop_lattice(offset, m.x_range[0], spacing, columns, ys, heights,
                 static_cast<int>(state.range(1)));
    benchmark::DoNotOptimize(heights.data());
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(heights.size()));
}
BENCHMARK(drop_lattice_solids400)->ArgsProduct({{100, 25}, {0}})->UseRealTime();

// Scattered points, on one core and on two.
void drop_points_solids400(benchmark::State& state) {
  if (left_out(state, solids400_mesh())) return;
  static const OffsetSurface offset(solids400_mesh(), *CutterShape::make({12, 6}), 0);
  static const PointDrop drop(offset);
  const Machining& m = solids400().program().machining;
  std::uint64_t seed = 1 + static_cast<std::uint64_t>(state.thread_index());
  const auto next = [&](const std::array<double, 2>& range) {
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return range[0] + (range[1] - range[0]) * static_cast<double>(seed >> 11) * 0x1p-53;
  };
  for (auto _ : state) {
    const double x = next(m.x_range), y = next(m.y_range);
    benchmark::DoNotOptimize(drop.at(x, y));
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(drop_points_solids400)->Threads(1)->Threads(2)->UseRealTime();

// fig6 with a ball of 6 at 0.02 and cusp 0.01, from the surface to the path.
void plan_fig6(benchmark::State& state) {
  static const CompoundSurface surface = bench::fixture("fig6");
  const PathOptions options = fig6_options();
  std::size_t points = 0;
  for (auto _ : state) {
    const Result<PlannedPath> planned = plan_path(surface, options);
    points = planned->path.points.size();
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(points));
}
BENCHMARK(plan_fig6)->UseRealTime()->Unit(benchmark::kMillisecond);

void plan_cc_fig6(benchmark::State& state) {
  static const CompoundSurface surface = bench::fixture("fig6");
  PathOptions options = fig6_options();
  options.method = PathMethod::kCc;
  for (auto _ : state) benchmark::DoNotOptimize(plan_path(surface, options));
}
BENCHMARK(plan_cc_fig6)->UseRealTime()->Unit(benchmark::kMillisecond);

// A path for fig6 cut into a million moves.
void verify_fig6_million(benchmark::State& state) {
  static const CompoundSurface surface = bench::fixture("fig6");
  const PathOptions how = fig6_options();
  const Result<PlannedPath> planned = plan_path(surface, how);
  ToolPath path = planned->path;
  path.points.clear();
  const auto& points = planned->path.points;
  const double piece = planned->report.feed_length / 1e6;
  for (std::size_t k = 1; k < points.size(); ++k) {
    const Vec3 d = points[k].tip - points[k - 1].tip;
    const double count = std::fmax(1, std::round(d.norm() / piece));
    for (double i = 1; i <= count; ++i) {
      path.points.push_back({points[k - 1].tip + d * (i / count), points[k].motion});
    }
  }
  const TriangleMesh mesh = mesh_of(surface, 0.00125);
  VerifyOptions options;
  options.cutter = how.cutter;
  options.intol = how.intol;
  options.outtol = how.outtol;
  options.cusp = how.cusp;
  for (auto _ : state) benchmark::DoNotOptimize(verify_path(surface, mesh, 0.00125, path, options));
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(path.points.size()));
}
BENCHMARK(verify_fig6_million)->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace diesink
