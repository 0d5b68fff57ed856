// Readers and writers of mesh formats, bytes a second, against other programs' on the same file in
// the same run.
// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <string>
#include <thread>

#include "formats/byte_sink.h"
#include "formats/mesh_file.h"
#include "formats/registry.h"

#ifdef DIESINK_BENCH_OPENMESH
#include <OpenMesh/Core/IO/MeshIO.hh>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#endif
#ifdef DIESINK_BENCH_TINYOBJ
#include <tiny_obj_loader.h>
#endif

namespace {

using namespace diesink;

// A waved sheet of 2 · n · n triangles in ten elements, with normals, in coordinates of many
// digits.
const TriangleMesh& sheet() {
  static const TriangleMesh mesh = [] {
    constexpr std::uint32_t kCells = 700;
    TriangleMesh made;
    made.unit = LengthUnit::kMillimetre;
    for (std::uint32_t j = 0; j <= kCells; ++j) {
      for (std::uint32_t i = 0; i <= kCells; ++i) {
        const double x = 160.0 * i / kCells, y = 120.0 * j / kCells;
        made.positions.emplace_back(x, y, 10 * std::sin(x / 13) * std::cos(y / 17));
        made.normals.push_back(Vec3(-10.0 / 13 * std::cos(x / 13) * std::cos(y / 17),
                                    10.0 / 17 * std::sin(x / 13) * std::sin(y / 17), 1)
                                   .normalized());
      }
    }
    for (std::uint32_t j = 0; j < kCells; ++j) {
      for (std::uint32_t i = 0; i < kCells; ++i) {
        const std::uint32_t a = j * (kCells + 1) + i, b = a + 1, c = b + kCells + 1, d = c - 1;
        made.triangles.push_back({a, b, c});
        made.triangles.push_back({a, c, d});
        made.triangle_element.insert(made.triangle_element.end(), 2, j * 10 / kCells);
      }
    }
    made.corner_normals = made.triangles;
    for (int e = 0; e < 10; ++e)
      made.elements.push_back({"S" + std::to_string(e) + ".side", "S" + std::to_string(e), {}});
    return made;
  }();
  return mesh;
}

WriteOptions options_for(bool ascii, bool normals) {
  WriteOptions options;
  options.program_comment = "diesink bench";
  options.ascii = ascii;
  options.normals = normals;
  return options;
}

enum class Where { kMemory, kDisk };

// A file in memory, so that no disk is measured; or on the disk, where the processor's time is
// what the program and the file system take, and the time is the disk's.
std::string scratch(const Format& format, Where where = Where::kMemory) {
  const bool memory = where == Where::kMemory && ::access("/dev/shm", W_OK) == 0;
  const char* const asked = std::getenv("TMPDIR");
  const char* const disk = asked != nullptr ? asked : "/tmp";
  return std::string(memory ? "/dev/shm" : disk) + "/diesink-bench-" + std::to_string(::getpid()) +
         std::string(format.extensions[0]);
}

void write_file_of(benchmark::State& state, const Format& format, bool ascii, bool normals,
                   Where where) {
  const std::string path = scratch(format, where);
  std::size_t size = 0;
  for (auto round : state) {
    OutputFiles files;
    if (!write_mesh_file(path, sheet(), options_for(ascii, normals), files) || !files.commit()) {
      state.SkipWithError("cannot write");
      return;
    }
  }
  if (const Result<InputBytes> written = read_file(path)) size = written->bytes().size();
  ::unlink(path.c_str());
  ::unlink((path.substr(0, path.rfind('.')) + ".mtl").c_str());
  state.SetBytesProcessed(static_cast<std::int64_t>(size) * state.iterations());
}

std::vector<std::byte> content(const Format& format, bool ascii, bool normals) {
  Result<WrittenMesh> written = format.write(sheet(), options_for(ascii, normals));
  return written ? std::move(written->files[0].bytes) : std::vector<std::byte>{};
}

// The bytes of that file as they are, in pieces of a megabyte: what the system allows a writer that
// has nothing to do.
void write_same_bytes_of(benchmark::State& state, const Format& format, Where where) {
  const std::string path = scratch(format, where);
  const std::vector<std::byte> bytes = content(format, false, true);
  for (auto round : state) {
    OutputFiles files;
    const Result<ByteSink*> sink = files.open(path);
    bool written = static_cast<bool>(sink);
    for (std::size_t at = 0; written && at < bytes.size(); at += ByteWriter::kBuffer) {
      const std::size_t size = std::min(ByteWriter::kBuffer, bytes.size() - at);
      written = static_cast<bool>((*sink)->put(std::span(bytes).subspan(at, size)));
    }
    if (!written || !files.commit()) {
      state.SkipWithError("cannot write");
      break;
    }
  }
  ::unlink(path.c_str());
  state.SetBytesProcessed(static_cast<std::int64_t>(bytes.size()) * state.iterations());
}

void read_bytes_of(benchmark::State& state, const Format& format, bool ascii, bool normals,
                   int threads) {
  const std::vector<std::byte> bytes = content(format, ascii, normals);
  ReadOptions options;
  options.threads = threads;
  for (auto round : state) {
    Diagnostics diagnostics;
    const Result<TriangleMesh> mesh = format.read(bytes, options, diagnostics);
    if (!mesh || mesh->triangles.size() != sheet().triangles.size()) {
      state.SkipWithError("cannot read");
      return;
    }
    benchmark::DoNotOptimize(mesh->positions.data());
  }
  state.SetBytesProcessed(static_cast<std::int64_t>(bytes.size()) * state.iterations());
}

// Two readings by one core each at the same time, which share nothing but the machine: what two
// cores can do at most for `_all_cores`.
void read_two_at_once(benchmark::State& state, const Format& format, bool ascii) {
  const std::vector<std::byte> bytes = content(format, ascii, false);
  ReadOptions options;
  options.threads = 1;
  for (auto round : state) {
    std::array<bool, 2> good{};
    const auto read = [&](std::size_t i) {
      Diagnostics diagnostics;
      const Result<TriangleMesh> mesh = format.read(bytes, options, diagnostics);
      good[i] = mesh && mesh->triangles.size() == sheet().triangles.size();
    };
    {
      const std::jthread other(read, 1U);
      read(0);
    }
    if (!good[0] || !good[1]) {
      state.SkipWithError("cannot read");
      return;
    }
  }
  state.SetBytesProcessed(2 * static_cast<std::int64_t>(bytes.size()) * state.iterations());
}

#ifdef DIESINK_BENCH_OPENMESH
void openmesh_read(benchmark::State& state, const Format& format, bool ascii) {
  const std::vector<std::byte> bytes = content(format, ascii, false);
  const std::string path = scratch(format);
  std::ofstream(path, std::ios::binary)
      .write(static_cast<const char*>(static_cast<const void*>(bytes.data())),
             static_cast<std::streamsize>(bytes.size()));
  for (auto round : state) {
    OpenMesh::TriMesh_ArrayKernelT<> mesh;
    OpenMesh::IO::Options options;
    if (!OpenMesh::IO::read_mesh(mesh, path, options)) {
      state.SkipWithError("OpenMesh cannot read");
      break;
    }
  }
  ::unlink(path.c_str());
  state.SetBytesProcessed(static_cast<std::int64_t>(bytes.size()) * state.iterations());
}

void openmesh_write(benchmark::State& state, const Format& format) {
  OpenMesh::TriMesh_ArrayKernelT<> mesh;
  for (const Vec3& p : sheet().positions) {
    mesh.add_vertex(
        {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())});
  }
  const auto handle = [](std::uint32_t v) { return OpenMesh::VertexHandle(static_cast<int>(v)); };
  for (const auto& t : sheet().triangles) mesh.add_face(handle(t[0]), handle(t[1]), handle(t[2]));
  const std::string path = scratch(format);
  OpenMesh::IO::Options options = OpenMesh::IO::Options::Default;
  if (&format != &kObj) options += OpenMesh::IO::Options::Binary;
  mesh.request_face_normals();
  mesh.update_face_normals();
  for (auto round : state) {
    if (!OpenMesh::IO::write_mesh(mesh, path, options, 9)) {
      state.SkipWithError("OpenMesh cannot write");
      break;
    }
  }
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  state.SetBytesProcessed(static_cast<std::int64_t>(file.tellg()) * state.iterations());
  ::unlink(path.c_str());
}
#endif

#ifdef DIESINK_BENCH_TINYOBJ
void tinyobj_read(benchmark::State& state) {
  const std::vector<std::byte> bytes = content(kObj, false, false);
  const std::string path = scratch(kObj);
  std::ofstream(path, std::ios::binary)
      .write(static_cast<const char*>(static_cast<const void*>(bytes.data())),
             static_cast<std::streamsize>(bytes.size()));
  for (auto round : state) {
    tinyobj::attrib_t attributes;
    std::vector<tinyobj::shape_t> shapes;
    std::vector<tinyobj::material_t> materials;
    std::string warnings, errors;
    if (!tinyobj::LoadObj(&attributes, &shapes, &materials, &warnings, &errors, path.c_str())) {
      state.SkipWithError("tinyobjloader cannot read");
      break;
    }
  }
  ::unlink(path.c_str());
  state.SetBytesProcessed(static_cast<std::int64_t>(bytes.size()) * state.iterations());
}
#endif

BENCHMARK_CAPTURE(write_file_of, stl_binary, kStl, false, true, Where::kMemory)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(write_file_of, stl_ascii, kStl, true, true, Where::kMemory)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(write_file_of, ply_binary, kPly, false, true, Where::kMemory)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(write_file_of, obj, kObj, false, true, Where::kMemory)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(write_file_of, off, kOff, false, true, Where::kMemory)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(write_file_of, glb, kGlb, false, true, Where::kMemory)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(write_file_of, stl_binary_on_disk, kStl, false, true, Where::kDisk)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(write_file_of, ply_binary_on_disk, kPly, false, true, Where::kDisk)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(write_file_of, glb_on_disk, kGlb, false, true, Where::kDisk)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(write_same_bytes_of, stl_binary, kStl, Where::kMemory)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(write_same_bytes_of, stl_binary_on_disk, kStl, Where::kDisk)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(write_same_bytes_of, glb, kGlb, Where::kMemory)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(write_same_bytes_of, glb_on_disk, kGlb, Where::kDisk)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(read_bytes_of, stl_binary_weld, kStl, false, false, 1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(read_bytes_of, stl_ascii_weld, kStl, true, false, 1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(read_bytes_of, ply_binary, kPly, false, true, 1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(read_bytes_of, obj, kObj, false, false, 1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(read_bytes_of, obj_with_normals, kObj, false, true, 1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(read_bytes_of, obj_all_cores, kObj, false, false, 0)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(read_bytes_of, stl_ascii_all_cores, kStl, true, false, 0)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(read_two_at_once, obj, kObj, false)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(read_two_at_once, stl_ascii, kStl, true)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(read_bytes_of, ply_ascii, kPly, true, false, 1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(read_bytes_of, ply_ascii_all_cores, kPly, true, false, 0)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(read_bytes_of, off, kOff, false, false, 1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(read_bytes_of, off_all_cores, kOff, false, false, 0)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
#ifdef DIESINK_BENCH_OPENMESH
BENCHMARK_CAPTURE(openmesh_read, stl_binary, kStl, false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(openmesh_read, stl_ascii, kStl, true)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(openmesh_write, stl_binary, kStl)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(openmesh_write, ply_binary, kPly)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(openmesh_write, obj, kObj)->Unit(benchmark::kMillisecond);
#endif
#ifdef DIESINK_BENCH_TINYOBJ
BENCHMARK(tinyobj_read)->Unit(benchmark::kMillisecond);
#endif

}  // namespace
