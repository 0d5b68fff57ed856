// Planar triangulation: building from random points and from arcs, refinement for shape and size.
// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "core/tessellate/planar_triangulation.h"

namespace diesink {
namespace {

struct Region {
  std::vector<Vec2> points;
  std::vector<PlanarTriangulation::Segment> segments;

  void add_circle(const Vec2& centre, double radius, std::int64_t count, double way_round) {
    const auto first = static_cast<std::uint32_t>(points.size());
    const auto corners = static_cast<std::uint32_t>(count);
    for (std::uint32_t i = 0; i < corners; ++i) {
      const double angle = way_round * 2 * std::numbers::pi * i / corners;
      points.push_back(centre + radius * Vec2(std::cos(angle), std::sin(angle)));
      segments.push_back({first + i, first + (i + 1) % corners});
    }
  }
};

void count_rate(benchmark::State& state, const char* what, std::size_t count) {
  state.counters[what] =
      benchmark::Counter(static_cast<double>(count), benchmark::Counter::kIsIterationInvariantRate);
}

void build_random(benchmark::State& state) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> unit(0, 1);
  Region region;
  region.points = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  region.segments = {{0, 1}, {1, 2}, {2, 3}, {3, 0}};
  for (std::int64_t i = 0; i < state.range(0); ++i) {
    const double x = unit(random);
    region.points.emplace_back(x, unit(random));
  }
  PlanarTriangulation mesh;
  for ([[maybe_unused]] auto _ : state) {
    benchmark::DoNotOptimize(mesh.build(region.points, region.segments));
  }
  count_rate(state, "points", region.points.size());
}
BENCHMARK(build_random)->Arg(100)->Arg(10000)->Arg(1000000)->Unit(benchmark::kMillisecond);

void build_ring(benchmark::State& state) {
  Region region;
  region.add_circle({0, 0}, 1, state.range(0), 1);
  region.add_circle({0.2, 0}, 0.7, state.range(0), -1);
  PlanarTriangulation mesh;
  for ([[maybe_unused]] auto _ : state) {
    benchmark::DoNotOptimize(mesh.build(region.points, region.segments));
  }
  count_rate(state, "points", region.points.size());
}
BENCHMARK(build_ring)->Arg(100)->Arg(10000)->Arg(200000)->Unit(benchmark::kMillisecond);

// An eccentric ring whose segments are split at their middles, until 20 degrees hold and no
// triangle is larger than 1 / range.
void refine_ring(benchmark::State& state) {
  Region region;
  region.add_circle({0, 0}, 1, 100, 1);
  region.add_circle({0.2, 0}, 0.7, 100, -1);
  std::size_t triangles = 0;
  for ([[maybe_unused]] auto _ : state) {
    PlanarTriangulation mesh;
    mesh.build(region.points, region.segments);
    RefineRules rules;
    rules.min_angle = 20 * std::numbers::pi / 180;
    const double most = 2.0 / static_cast<double>(state.range(0));
    rules.too_coarse = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
      const Vec2 u = mesh.points()[b] - mesh.points()[a], v = mesh.points()[c] - mesh.points()[a];
      return u.x() * v.y() - u.y() * v.x() > most;
    };
    for (auto asked = mesh.refine(rules); !asked.empty(); asked = mesh.refine(rules)) {
      for (const PlanarTriangulation::Segment& s : asked) {
        mesh.split_segment(s[0], s[1], 0.5 * (mesh.points()[s[0]] + mesh.points()[s[1]]));
      }
    }
    triangles = mesh.triangles().size();
  }
  count_rate(state, "triangles", triangles);
  state.counters["count"] = static_cast<double>(triangles);
}
BENCHMARK(refine_ring)->Arg(1)->Arg(10000)->Arg(300000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace diesink
