// Adaptive tessellation: the paper's die, pockets and bosses on a plate, and many solids at one
// density. Rates are triangles a second.
// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>

#include "bench/bench_parts.h"
#include "core/tessellate/tessellate.h"

namespace diesink {
namespace {

void run(benchmark::State& state, const CompoundSurface& surface, double tolerance,
         MeshScheme scheme = MeshScheme::kAdaptive) {
  TessellationOptions options;
  options.tolerance = tolerance;
  options.scheme = scheme;
  std::size_t triangles = 0;
  for ([[maybe_unused]] auto _ : state) {
    const Result<Tessellation> made = tessellate(surface, options);
    if (!made) {
      state.SkipWithError(to_text(made.error()).c_str());
      return;
    }
    triangles = made->mesh.triangles.size();
    state.counters["certified/tol"] = made->report.certified_deviation / tolerance;
    state.counters["uncertified_area"] = made->report.uncertified_area;
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(triangles));
  state.counters["triangles"] = static_cast<double>(triangles);
}

void fig6(benchmark::State& state) {
  run(state, bench::fixture("fig6"), 1e-3 * static_cast<double>(state.range(0)));
}
BENCHMARK(fig6)->ArgName("um")->Arg(20)->Arg(1)->UseRealTime()->Unit(benchmark::kMillisecond);

void fig6_grid(benchmark::State& state) {
  run(state, bench::fixture("fig6"), 0.02, MeshScheme::kGrid);
}
BENCHMARK(fig6_grid)->UseRealTime()->Unit(benchmark::kMillisecond);

void pockets(benchmark::State& state) {
  run(state, bench::fixture("pockets"), 1e-3 * static_cast<double>(state.range(0)));
}
BENCHMARK(pockets)->ArgName("um")->Arg(10)->UseRealTime()->Unit(benchmark::kMillisecond);

// The same density: 400 solids on a square metre.
void solids(benchmark::State& state) {
  run(state, bench::generated("solids" + std::to_string(state.range(0))), 0.05);
}
BENCHMARK(solids)->Arg(100)->Arg(400)->Arg(1600)->Arg(6400)->UseRealTime()->Unit(
    benchmark::kMillisecond);

}  // namespace
}  // namespace diesink
