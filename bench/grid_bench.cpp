// Evaluation: whole grids with normals and labels, single points, bounds, edges.
// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>

#include "bench/bench_parts.h"
#include "core/base/ferguson.h"
#include "core/grid/edges.h"
#include "core/grid/grid_array.h"

namespace diesink {
namespace {

std::vector<double> even_lines(const std::array<double, 2>& range, int count) {
  return grid_lines(range[0], range[1], (range[1] - range[0]) / (count - 1));
}

void grid(benchmark::State& state, const CompoundSurface& surface, std::vector<double> x,
          std::vector<double> y, int threads) {
  GridArray array(std::move(x), std::move(y));
  for (auto _ : state) {
    fill_grid(surface, array, threads);
    benchmark::DoNotOptimize(array.z().data());
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(array.size()));
}

// Arguments: spacing in thousandths of the unit, threads.
void grid_fig6_spacing(benchmark::State& state) {
  static const CompoundSurface surface = bench::fixture("fig6");
  const Machining& m = surface.program().machining;
  const double spacing = static_cast<double>(state.range(0)) / 1000;
  grid(state, surface, grid_lines(m.x_range[0], m.x_range[1], spacing),
       grid_lines(m.y_range[0], m.y_range[1], spacing), static_cast<int>(state.range(1)));
}
BENCHMARK(grid_fig6_spacing)->ArgsProduct({{800, 100, 20}, {0}})->UseRealTime();

void grid_1000(benchmark::State& state, const CompoundSurface& surface) {
  const Machining& m = surface.program().machining;
  grid(state, surface, even_lines(m.x_range, 1000), even_lines(m.y_range, 1000),
       static_cast<int>(state.range(0)));
}
// Argument: threads, 0 = all cores.
void grid_fig6_1000(benchmark::State& state) {
  static const CompoundSurface surface = bench::fixture("fig6");
  grid_1000(state, surface);
}
BENCHMARK(grid_fig6_1000)->Arg(1)->Arg(0)->UseRealTime();

void grid_solids400_1000(benchmark::State& state) {
  static const CompoundSurface surface = bench::generated("solids400");
  grid_1000(state, surface);
}
BENCHMARK(grid_solids400_1000)->Arg(1)->Arg(0)->UseRealTime();

void grid_solids400_warped_base_1000(benchmark::State& state) {
  static const CompoundSurface surface = bench::generated("solids400w");
  grid_1000(state, surface);
}
BENCHMARK(grid_solids400_warped_base_1000)->Arg(1)->Arg(0)->UseRealTime();

// From nothing, the array's memory and its threads included.
void grid_fig6_1000_fresh(benchmark::State& state) {
  static const CompoundSurface surface = bench::fixture("fig6");
  const Machining& m = surface.program().machining;
  for (auto _ : state) {
    const Result<GridArray> array =
        evaluate_grid(surface, even_lines(m.x_range, 1000), even_lines(m.y_range, 1000), 0);
    benchmark::DoNotOptimize(array->z().data());
  }
  state.SetItemsProcessed(state.iterations() * 1000000);
}
BENCHMARK(grid_fig6_1000_fresh)->UseRealTime();

void points(benchmark::State& state, const CompoundSurface& surface) {
  const Machining& m = surface.program().machining;
  std::uint64_t k = 0;
  for (auto _ : state) {
    // A low-discrepancy walk: no two neighbours alike.
    const double u = static_cast<double>(++k * 0x9E3779B97F4A7C15u >> 11) * 0x1p-53;
    const double v = static_cast<double>(k * 0xD1B54A32D192ED03u >> 11) * 0x1p-53;
    benchmark::DoNotOptimize(surface.at(m.x_range[0] + u * (m.x_range[1] - m.x_range[0]),
                                        m.y_range[0] + v * (m.y_range[1] - m.y_range[0])));
  }
  state.SetItemsProcessed(state.iterations());
}
void point_fig6(benchmark::State& state) {
  static const CompoundSurface surface = bench::fixture("fig6");
  points(state, surface);
}
BENCHMARK(point_fig6);
void point_solids400_warped_base(benchmark::State& state) {
  static const CompoundSurface surface = bench::generated("solids400w");
  points(state, surface);
}
BENCHMARK(point_solids400_warped_base);

void base_bounds(benchmark::State& state, const std::string& part) {
  const CompoundSurface surface = part == "fig6" ? bench::fixture(part) : bench::generated(part);
  const FergusonSurface base =
      std::move(*FergusonSurface::make(std::get<FergusonBase>(surface.program().base)));
  const PlanBox all = base.plan_box();
  const double h = 1e-4 * (all.x1 - all.x0);
  std::uint64_t k = 0;
  for (auto _ : state) {
    const double u = static_cast<double>(++k * 0x9E3779B97F4A7C15u >> 11) * 0x1p-53;
    const double v = static_cast<double>(k * 0xD1B54A32D192ED03u >> 11) * 0x1p-53;
    const double x = all.x0 + u * (all.x1 - all.x0), y = all.y0 + v * (all.y1 - all.y0);
    benchmark::DoNotOptimize(base.bounds({x, x + h, y, y + h}));
  }
  state.SetItemsProcessed(state.iterations());
}
void bounds_affine_base(benchmark::State& state) { base_bounds(state, "fig6"); }
BENCHMARK(bounds_affine_base);
void bounds_warped_base(benchmark::State& state) { base_bounds(state, "solids400w"); }
BENCHMARK(bounds_warped_base);

void edges(benchmark::State& state, const CompoundSurface& surface, std::vector<double> x,
           std::vector<double> y) {
  const GridArray array = std::move(*evaluate_grid(surface, std::move(x), std::move(y), 0));
  std::size_t found = 0;
  for (auto _ : state) found = find_edges(surface, array, 0).size();
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(found));
}
void edges_fig6(benchmark::State& state) {
  static const CompoundSurface surface = bench::fixture("fig6");
  const Machining& m = surface.program().machining;
  edges(state, surface, grid_lines(m.x_range[0], m.x_range[1], 0.1),
        grid_lines(m.y_range[0], m.y_range[1], 0.1));
}
BENCHMARK(edges_fig6)->UseRealTime();
void edges_solids400(benchmark::State& state) {
  static const CompoundSurface surface = bench::generated("solids400");
  const Machining& m = surface.program().machining;
  edges(state, surface, even_lines(m.x_range, 1000), even_lines(m.y_range, 1000));
}
BENCHMARK(edges_solids400)->UseRealTime();

}  // namespace
}  // namespace diesink
