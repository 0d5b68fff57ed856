// glTF: writing and reading GLB, and Draco against the library alone (the same primitives, bits and
// speed, encoded and decoded once, nothing checked).
// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>
#include <draco/compression/decode.h>
#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>

#include "formats/byte_sink.h"
#include "formats/draco_mesh.h"
#include "formats/gltf_layout.h"
#include "formats/gltf_split.h"
#include "formats/registry.h"
#include "tests/support/die_mesh.h"

namespace {

using namespace diesink;

const TriangleMesh& die() {
  static const TriangleMesh mesh = test::die_mesh(700, 160, 2);  // about a million triangles
  return mesh;
}

class Counted final : public FileSet, public ByteSink {
 public:
  Result<ByteSink*> file(std::string_view /*name*/) override {
    return static_cast<ByteSink*>(this);
  }
  Status put(std::span<const std::byte> bytes) override {
    benchmark::DoNotOptimize(bytes.data());
    size += bytes.size();
    return ok();
  }
  std::size_t size = 0;
};

// Everything but the disk: the bytes go through the writer's buffer and are counted.
void write_glb(benchmark::State& state, bool normals) {
  die();  // made before the clock starts
  WriteOptions options;
  options.normals = normals;
  std::size_t size = 0;
  for (auto _ : state) {
    Counted out;
    if (!kGlb.stream(die(), options, out)) state.SkipWithError("not written");
    size += out.size;
  }
  state.SetBytesProcessed(static_cast<std::int64_t>(size));
}

WriteOptions draco_file() {
  WriteOptions options;
  options.draco = true;
  options.tolerance = 0.01;
  return options;
}

void read_glb(benchmark::State& state, bool draco) {
  WriteOptions options = draco_file();
  options.draco = draco;
  const auto file = kGlb.write(die(), options);
  ReadOptions reading;
  std::size_t size = 0;
  for (auto _ : state) {
    Diagnostics diagnostics;
    const auto mesh = kGlb.read(file->files[0].bytes, reading, diagnostics);
    if (!mesh) state.SkipWithError("not read");
    size += file->files[0].bytes.size();
  }
  state.SetBytesProcessed(static_cast<std::int64_t>(size));
  state.counters["triangles/s"] = benchmark::Counter(static_cast<double>(die().triangles.size()),
                                                     benchmark::Counter::kIsIterationInvariantRate);
}

void draco_write_glb(benchmark::State& state) {
  WriteOptions options;
  options.draco = true;
  options.quantize_bits = 14;
  for (auto _ : state) {
    Counted out;
    if (!kGlb.stream(die(), options, out)) state.SkipWithError("not written");
    state.counters["bytes"] = static_cast<double>(out.size);
  }
}

// The library by its own example: a mesh a primitive, values deduplicated by it. Empty on an error.
std::vector<draco::EncoderBuffer> encode_by_library() {
  const auto split = split_by_element(die(), true);
  std::vector<draco::EncoderBuffer> buffers;
  for (const SplitPrimitive& part : split->primitives) {
    draco::Mesh mesh;
    mesh.set_num_points(part.vertex_count);
    mesh.SetNumFaces(part.triangle_count);
    for (std::uint32_t f = 0; f < part.triangle_count; ++f) {
      const auto& t = split->triangles[part.first_triangle + f];
      mesh.SetFace(draco::FaceIndex(f),
                   {draco::PointIndex(t[0]), draco::PointIndex(t[1]), draco::PointIndex(t[2])});
    }
    const auto add = [&](draco::GeometryAttribute::Type type, const std::vector<Vec3>& values,
                         const std::vector<std::uint32_t>& of_vertex) {
      auto attribute = std::make_unique<draco::PointAttribute>();
      attribute->Init(type, 3, draco::DT_FLOAT32, false, part.vertex_count);
      attribute->SetIdentityMapping();
      for (std::uint32_t v = 0; v < part.vertex_count; ++v) {
        const Vec3& p = values[of_vertex[part.first_vertex + v]];
        const std::array<float, 3> value{static_cast<float>(p.x()), static_cast<float>(p.y()),
                                         static_cast<float>(p.z())};
        attribute->SetAttributeValue(draco::AttributeValueIndex(v), value.data());
      }
      return mesh.AddAttribute(std::move(attribute));
    };
    const int position = add(draco::GeometryAttribute::POSITION, die().positions, split->position);
    const int normal = add(draco::GeometryAttribute::NORMAL, die().normals, split->normal);
    mesh.DeduplicateAttributeValues();
    draco::ExpertEncoder encoder(mesh);
    encoder.SetSpeedOptions(3, 3);
    encoder.SetAttributeQuantization(position, 14);
    encoder.SetAttributeQuantization(normal, 10);
    if (!encoder.EncodeToBuffer(&buffers.emplace_back()).ok()) return {};
  }
  return buffers;
}

bool decode_by_library(const std::vector<draco::EncoderBuffer>& buffers) {
  for (const draco::EncoderBuffer& buffer : buffers) {
    draco::DecoderBuffer in;
    in.Init(buffer.data(), buffer.size());
    draco::Decoder decoder;
    if (!decoder.DecodeMeshFromBuffer(&in).ok()) return false;
  }
  return !buffers.empty();
}

void draco_library(benchmark::State& state) {
  for (auto _ : state) {
    const std::vector<draco::EncoderBuffer> buffers = encode_by_library();
    if (!decode_by_library(buffers)) state.SkipWithError("not encoded");
    std::size_t bytes = 0;
    for (const draco::EncoderBuffer& buffer : buffers) bytes += buffer.size();
    state.counters["bytes"] = static_cast<double>(bytes);
  }
}

// The streams of the file that read_glb/draco reads, by the library alone: without glTF, checks and
// the joining of vertices.
void draco_library_decode(benchmark::State& state) {
  const Result<GltfLayout> layout = lay_out(die(), draco_file());
  std::vector<draco::EncoderBuffer> buffers;
  for (const DracoBlob& blob : layout->blobs) {
    buffers.emplace_back().Encode(blob.bytes.data(), blob.bytes.size());
  }
  for (auto _ : state) {
    if (!decode_by_library(buffers)) state.SkipWithError("not decoded");
  }
}

BENCHMARK_CAPTURE(write_glb, with_normals, true)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(write_glb, positions, false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(read_glb, plain, false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(read_glb, draco, true)->Unit(benchmark::kMillisecond);
BENCHMARK(draco_write_glb)->Unit(benchmark::kMillisecond);
BENCHMARK(draco_library)->Unit(benchmark::kMillisecond);
BENCHMARK(draco_library_decode)->Unit(benchmark::kMillisecond);

}  // namespace
