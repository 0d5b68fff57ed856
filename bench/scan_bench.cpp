// The scanned base: z, face and normal over grids from a loaded mesh, single points, and Embree on
// the same mesh where it is installed.
// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>

#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/base/scanned.h"
#include "core/grid/grid_array.h"
#include "core/large_array.h"
#include "core/parallel.h"
#include "formats/mesh_file.h"
#include "formats/registry.h"
#include "tests/support/height_mesh.h"

#ifdef DIESINK_BENCH_EMBREE
#include <embree3/rtcore.h>
#endif

namespace diesink {
namespace {

constexpr double kSize = 400;

// A relief of 2 (points - 1)² triangles; `order` 1 shuffles them.
TriangleMesh relief(std::uint32_t points, bool shuffled) {
  TriangleMesh mesh = test::height_mesh(0, kSize, points, 0, kSize, points, [](double x, double y) {
    return 8 * std::sin(x / 23) * std::cos(y / 31) + 0.1 * std::sin(3 * x + 2 * y);
  });
  if (shuffled) std::shuffle(mesh.triangles.begin(), mesh.triangles.end(), std::mt19937(7));
  return mesh;
}

std::uint32_t points_of(std::int64_t million) { return million == 1 ? 708 : 2001; }

struct Grid {
  std::vector<double> lines, z, nx, ny, nz;
  std::vector<std::uint32_t> face;
  explicit Grid(std::int64_t million) : Grid(million == 1 ? 1000U : 4000U) {}
  explicit Grid(std::uint32_t count) {
    lines = grid_lines(0, kSize, kSize / (count - 1));
    const std::size_t n = lines.size() * lines.size();
    for (std::vector<double>* v : {&z, &nx, &ny, &nz}) v->assign(n, 0);
    face.assign(n, 0);
  }
  [[nodiscard]] ScannedGrid out() {
    return {z.data(), nx.data(), ny.data(), nz.data(), face.data()};
  }
};

// Arguments: millions of triangles (1 onto 1000 x 1000, 8 onto 4000 x 4000), random order, threads.
void scan_grid(benchmark::State& state) {
  const Result<ScannedSurface> scan =
      ScannedSurface::make(relief(points_of(state.range(0)), state.range(1) != 0), {});
  Grid grid(state.range(0));
  for (auto _ : state) {
    scan->grid(grid.lines, grid.lines, grid.out(), static_cast<int>(state.range(2)));
    benchmark::DoNotOptimize(grid.z.data());
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(grid.z.size()));
}
BENCHMARK(scan_grid)
    ->ArgsProduct({{1, 8}, {0, 1}, {1, 2}})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

// Time grows with triangles plus grid points, not their product: thousands of triangles onto
// thousands of points. Compare a row with those of a sixteenth of either.
void scan_growth(benchmark::State& state) {
  const auto across = [](std::int64_t thousands) {
    return static_cast<std::uint32_t>(
        std::lround(std::sqrt(1000.0 * static_cast<double>(thousands))));
  };
  TriangleMesh mesh =
      test::height_mesh(0, kSize, across(state.range(0) / 2), 0, kSize, across(state.range(0) / 2),
                        [](double x, double y) { return 8 * std::sin(x / 23) * std::cos(y / 31); });
  const Result<ScannedSurface> scan = ScannedSurface::make(std::move(mesh), {});
  Grid grid(across(state.range(1)));
  for (auto _ : state) {
    scan->grid(grid.lines, grid.lines, grid.out(), 1);
    benchmark::DoNotOptimize(grid.z.data());
  }
}
BENCHMARK(scan_growth)
    ->ArgsProduct({{64, 1024, 8192}, {64, 1024, 16384}})
    ->Unit(benchmark::kMillisecond);

// How the layers of a scan without any are told, pair by pair of what shares a cell.
void scan_layers(benchmark::State& state) {
  const Result<ScannedSurface> scan =
      ScannedSurface::make(relief(points_of(state.range(0)), false), {});
  benchmark::DoNotOptimize(scan->upright());
  for (auto _ : state) benchmark::DoNotOptimize(scan->layers(1).any());
}
BENCHMARK(scan_layers)->Arg(1)->Unit(benchmark::kMillisecond);

// To the surface, and to the plan grid that single points, rows and boxes look into.
void scan_make(benchmark::State& state) {
  const TriangleMesh mesh = relief(points_of(state.range(0)), false);
  for (auto _ : state) {
    state.PauseTiming();
    TriangleMesh copy = mesh;
    state.ResumeTiming();
    const Result<ScannedSurface> scan = ScannedSurface::make(std::move(copy), {});
    benchmark::DoNotOptimize(scan->upright());
  }
}
BENCHMARK(scan_make)->Arg(1)->Arg(8)->UseRealTime()->Unit(benchmark::kMillisecond);

// From a binary STL file in the system's cache to a surface that grids can be drawn of: read, weld,
// extent. `plan_ms` is what the first single point takes beyond that, the plan grid. Arguments as
// above, without threads.
void scan_load(benchmark::State& state) {
  const std::string path = std::filesystem::temp_directory_path() /
                           ("diesink_scan_" + std::to_string(::getpid()) + ".stl");
  {
    const TriangleMesh mesh = relief(points_of(state.range(0)), state.range(1) != 0);
    const Result<WrittenMesh> stl = kStl.write(mesh, {});
    if (!stl) return state.SkipWithError("no STL");
    const std::vector<std::byte>& bytes = stl->files[0].bytes;
    std::ofstream(path, std::ios::binary)
        .write(static_cast<const char*>(static_cast<const void*>(bytes.data())),
               static_cast<std::streamsize>(bytes.size()));
  }
  double read = 0, plan = 0;
  for (auto _ : state) {
    const auto begin = std::chrono::steady_clock::now();
    Diagnostics diagnostics;
    Result<MeshFile> file = read_mesh_file(path, {}, diagnostics);
    if (!file) {
      state.SkipWithError(file.error().message.c_str());
      break;
    }
    read +=
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
    const Result<ScannedSurface> scan = ScannedSurface::make(std::move(file->mesh), {});
    state.PauseTiming();
    const auto made = std::chrono::steady_clock::now();
    benchmark::DoNotOptimize(scan->upright());
    plan +=
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - made).count();
    state.ResumeTiming();
  }
  state.counters["plan_ms"] = benchmark::Counter(plan, benchmark::Counter::kAvgIterations);
  state.counters["read_ms"] = benchmark::Counter(read, benchmark::Counter::kAvgIterations);
  std::filesystem::remove(path);
}
BENCHMARK(scan_load)->ArgsProduct({{1, 8}, {0, 1}})->UseRealTime()->Unit(benchmark::kMillisecond);

// The bare memory traffic of a weld by table, facets in random order, to compare scan_load with:
// the bytes copied once (from memory, no file), one look a corner at random into 16-byte slots,
// twice as many as vertices, and the answer written to fresh memory. No bound for welds of other
// kinds. Argument: millions of triangles.
void scan_load_bare(benchmark::State& state) {
  const std::size_t points = points_of(state.range(0)), triangles = 2 * (points - 1) * (points - 1);
  const std::size_t slots = std::bit_ceil(2 * points * points);
  const std::vector<std::byte> file(84 + 50 * triangles, std::byte{1});
  for (auto _ : state) {
    const LargeArray<std::array<std::uint64_t, 2>> table(slots);
    const LargeArray<std::uint32_t> corners(3 * triangles);
    const LargeArray<std::array<double, 3>> positions(points * points);
    constexpr std::size_t kBlock = 512;
    parallel_blocks(slots, 1 << 16, 0, [&](std::size_t begin, std::size_t end, int) {
      std::fill(table.data() + begin, table.data() + end, std::array<std::uint64_t, 2>{1, 2});
    });
    parallel_blocks(triangles, kBlock, 0, [&](std::size_t begin, std::size_t end, int) {
      std::array<std::byte, 50 * kBlock> room;
      std::copy_n(file.data() + 84 + 50 * begin, 50 * (end - begin), room.data());
      benchmark::DoNotOptimize(room.data());
      std::array<std::size_t, 3 * kBlock> at;
      for (std::size_t i = 3 * begin; i < 3 * end; ++i) {
        std::uint64_t h = (i + 1) * 0x9E3779B97F4A7C15ULL;
        h = (h ^ h >> 29) * 0xBF58476D1CE4E5B9ULL;
        at[i - 3 * begin] = (h ^ h >> 32) & (slots - 1);
        __builtin_prefetch(&table.data()[at[i - 3 * begin]]);
      }
      for (std::size_t i = 3 * begin; i < 3 * end; ++i) {
        corners.data()[i] = static_cast<std::uint32_t>(table.data()[at[i - 3 * begin]][0]);
      }
    });
    parallel_blocks(points * points, 1 << 16, 0, [&](std::size_t begin, std::size_t end, int) {
      std::fill(positions.data() + begin, positions.data() + end, std::array<double, 3>{});
    });
    benchmark::DoNotOptimize(corners.data());
    benchmark::DoNotOptimize(positions.data());
  }
}
BENCHMARK(scan_load_bare)->Arg(1)->Arg(8)->UseRealTime()->Unit(benchmark::kMillisecond);

// Bytes a triangle over the mesh itself, at the most, by the system's count of resident pages:
// while the surface is made (`make`) and its plan grid (`plan`), after (`kept`), and while a grid
// is drawn with the plan grid there (`grid`).
class PeakMemory {
 public:
  PeakMemory() { reset(); }
  // Bytes resident now, and the most since the last reset.
  static double now() { return field("VmRSS:"); }
  static double peak() { return field("VmHWM:"); }
  static void reset() { std::ofstream("/proc/self/clear_refs") << "5"; }

 private:
  static double field(const std::string& name) {
    std::ifstream status("/proc/self/status");
    std::string word;
    double kilobytes = 0;
    while (status >> word) {
      if (word == name && status >> kilobytes) break;
    }
    return 1024 * kilobytes;
  }
};

// Each triangle with three vertices of its own, as formats without sharing have them.
TriangleMesh unshared(const TriangleMesh& mesh) {
  TriangleMesh apart;
  apart.positions.reserve(3 * mesh.triangles.size());
  apart.triangles.reserve(mesh.triangles.size());
  for (const std::array<std::uint32_t, 3>& t : mesh.triangles) {
    const auto first = static_cast<std::uint32_t>(apart.positions.size());
    for (const std::uint32_t v : t) apart.positions.push_back(mesh.positions[v]);
    apart.triangles.push_back({first, first + 1, first + 2});
  }
  return apart;
}

void scan_memory(benchmark::State& state) {
  double make = 0, plan = 0, kept = 0, drawn = 0;
  for (auto _ : state) {
    TriangleMesh mesh = relief(points_of(state.range(0)), state.range(1) != 0);
    MeshBase base;
    base.smooth_normals = state.range(2) != 0;
    if (state.range(3) != 0) mesh = unshared(mesh);
    Grid grid(state.range(0));
    const auto triangles = static_cast<double>(mesh.triangles.size());
    const double before = PeakMemory::now();
    PeakMemory::reset();
    const Result<ScannedSurface> scan = ScannedSurface::make(std::move(mesh), base);
    make = (PeakMemory::peak() - before) / triangles;
    PeakMemory::reset();
    benchmark::DoNotOptimize(scan->upright());
    plan = (PeakMemory::peak() - before) / triangles;
    kept = (PeakMemory::now() - before) / triangles;
    PeakMemory::reset();
    scan->grid(grid.lines, grid.lines, grid.out(), 0);
    drawn = (PeakMemory::peak() - before) / triangles;
  }
  state.counters["make"] = make;
  state.counters["plan"] = plan;
  state.counters["kept"] = kept;
  state.counters["grid"] = drawn;
}
// Arguments: millions of triangles, random order, NORMALS,SMOOTH, vertices a triangle of its own.
BENCHMARK(scan_memory)
    ->ArgsProduct({{8}, {0, 1}, {0, 1}, {0, 1}})
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

void scan_points(benchmark::State& state) {
  const Result<ScannedSurface> scan =
      ScannedSurface::make(relief(points_of(state.range(0)), false), {});
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> place(0, kSize);
  std::vector<Vec2> points(1 << 16);
  for (Vec2& p : points) p = Vec2(place(random), place(random));
  std::size_t k = 0;
  for (auto _ : state) {
    BaseHit hit;
    const Vec2& p = points[k++ & 0xFFFF];
    benchmark::DoNotOptimize(scan->at(p.x(), p.y(), hit));
    benchmark::DoNotOptimize(hit);
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(scan_points)->Arg(1)->Arg(8);

#ifdef DIESINK_BENCH_EMBREE
// One thread, packets of 4 x 4 rays; arguments as above, `built` includes the tree.
void embree_grid(benchmark::State& state) {
  const TriangleMesh mesh = relief(points_of(state.range(0)), state.range(1) != 0);
  const Grid grid(state.range(0));
  const RTCDevice device = rtcNewDevice("threads=1");
  double worst = 0;
  const Result<ScannedSurface> exact = ScannedSurface::make(mesh, {});
  for (auto _ : state) {
    const RTCScene scene = rtcNewScene(device);
    const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* const vertices = static_cast<float*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                3 * sizeof(float), mesh.positions.size()));
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
      for (int k = 0; k < 3; ++k) {
        vertices[3 * i + static_cast<std::size_t>(k)] = static_cast<float>(mesh.positions[i][k]);
      }
    }
    auto* const faces = static_cast<std::uint32_t*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                3 * sizeof(std::uint32_t), mesh.triangles.size()));
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      std::copy_n(mesh.triangles[i].begin(), 3, faces + 3 * i);
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    alignas(64) int valid[16];
    alignas(64) RTCRayHit16 packet;
    const std::size_t n = grid.lines.size() / 4 * 4;
    for (std::size_t j = 0; j < n; j += 4) {
      for (std::size_t i = 0; i < n; i += 4) {
        for (unsigned k = 0; k < 16; ++k) {
          valid[k] = -1;
          packet.ray.org_x[k] = static_cast<float>(grid.lines[i + k % 4]);
          packet.ray.org_y[k] = static_cast<float>(grid.lines[j + k / 4]);
          packet.ray.org_z[k] = 100;
          packet.ray.dir_x[k] = packet.ray.dir_y[k] = 0;
          packet.ray.dir_z[k] = -1;
          packet.ray.tnear[k] = packet.ray.time[k] = 0;
          packet.ray.tfar[k] = 1e9F;
          packet.ray.mask[k] = ~0U;
          packet.ray.flags[k] = 0;
          packet.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
          packet.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
        }
        rtcIntersect16(valid, scene, &context, &packet);
        benchmark::DoNotOptimize(packet.hit.primID[0]);
        BaseHit hit;
        if ((i / 4 + j / 4) % 64 == 0 && exact->at(grid.lines[i], grid.lines[j], hit)) {
          worst =
              std::fmax(worst, std::fabs(100.0 - static_cast<double>(packet.ray.tfar[0]) - hit.z));
        }
      }
    }
    rtcReleaseScene(scene);
  }
  rtcReleaseDevice(device);
  state.counters["worst_dz"] = worst;
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(grid.z.size()));
}
BENCHMARK(embree_grid)
    ->ArgsProduct({{1, 8}, {0, 1}})
    ->Iterations(1)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
#endif

}  // namespace
}  // namespace diesink
