// The scanned base: z, face and normal over grids from a loaded mesh, single points, and Embree on
// the same mesh where it is installed.
// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>

#include <unistd.h>

#include <algorithm>
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
  explicit Grid(std::int64_t million) {
    const int count = million == 1 ? 1000 : 4000;
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

// The plan grid of single points and rows.
void scan_make(benchmark::State& state) {
  const TriangleMesh mesh = relief(points_of(state.range(0)), false);
  for (auto _ : state) {
    state.PauseTiming();
    TriangleMesh copy = mesh;
    state.ResumeTiming();
    benchmark::DoNotOptimize(ScannedSurface::make(std::move(copy), {}));
  }
}
BENCHMARK(scan_make)->Arg(1)->Arg(8)->UseRealTime()->Unit(benchmark::kMillisecond);

// From a binary STL file in the system's cache to the surface: read, weld, plan grid. Arguments as
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
  double read = 0;
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
    benchmark::DoNotOptimize(ScannedSurface::make(std::move(file->mesh), {}));
  }
  state.counters["read_ms"] = benchmark::Counter(read, benchmark::Counter::kAvgIterations);
  std::filesystem::remove(path);
}
BENCHMARK(scan_load)->ArgsProduct({{1, 8}, {0, 1}})->UseRealTime()->Unit(benchmark::kMillisecond);

// Bytes a triangle over the mesh itself, at the most, by the system's count of resident pages:
// while the plan grid is made (`make`), after (`kept`), and while a grid is drawn (`grid`).
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

void scan_memory(benchmark::State& state) {
  double make = 0, kept = 0, drawn = 0;
  for (auto _ : state) {
    TriangleMesh mesh = relief(points_of(state.range(0)), state.range(1) != 0);
    MeshBase base;
    base.smooth_normals = state.range(2) != 0;
    Grid grid(state.range(0));
    const auto triangles = static_cast<double>(mesh.triangles.size());
    const double before = PeakMemory::now();
    PeakMemory::reset();
    const Result<ScannedSurface> scan = ScannedSurface::make(std::move(mesh), base);
    make = (PeakMemory::peak() - before) / triangles;
    kept = (PeakMemory::now() - before) / triangles;
    PeakMemory::reset();
    scan->grid(grid.lines, grid.lines, grid.out(), 0);
    drawn = (PeakMemory::peak() - before) / triangles;
  }
  state.counters["make"] = make;
  state.counters["kept"] = kept;
  state.counters["grid"] = drawn;
}
// Arguments: millions of triangles, random order, NORMALS,SMOOTH.
BENCHMARK(scan_memory)
    ->ArgsProduct({{1, 8}, {0, 1}, {0, 1}})
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
