// Draco in glTF: creases closed, deviation kept and told, odd geometry, damaged streams.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include "formats/draco_mesh.h"
#include "formats/draco_survey.h"
#include "formats/registry.h"
#include "tests/support/die_mesh.h"

namespace diesink {
namespace {

WriteOptions with_draco(double tolerance) {
  WriteOptions options;
  options.draco = true;
  options.lines = true;
  options.tolerance = tolerance;
  return options;
}

TriangleMesh read_back(const WrittenMesh& file) {
  Diagnostics diagnostics;
  ReadOptions options;
  options.file_name = "test.glb";
  auto mesh = kGlb.read(file.files[0].bytes, options, diagnostics);
  EXPECT_TRUE(mesh) << mesh.error().message;
  EXPECT_TRUE(diagnostics.all().empty()) << diagnostics.all()[0].message;
  return mesh ? std::move(*mesh) : TriangleMesh{};
}

double farthest(const TriangleMesh& from, const TriangleMesh& to) {
  double worst = 0;
  for (const Vec3& p : from.positions) {
    double nearest = 1e300;
    for (const Vec3& q : to.positions) nearest = std::min(nearest, (p - q).squaredNorm());
    worst = std::max(worst, std::sqrt(nearest));
  }
  return worst;
}

TEST(GltfDraco, CreasesStayClosedToTheBit) {
  const TriangleMesh mesh = test::die_mesh(30, 60, 4);
  for (const Vec3& at : {Vec3(0, 0, 0), Vec3(-3.3e5, 1e4, 77)}) {
    const auto file = kGlb.write(test::die_mesh(30, 60, 4, at), with_draco(0.01));
    ASSERT_TRUE(file);
    EXPECT_TRUE(file->notes.empty()) << file->notes[0];
    const TriangleMesh back = read_back(*file);
    // Vertices equal in several primitives are one again: none was split, none joined to another.
    EXPECT_EQ(back.positions.size(), mesh.positions.size());
    EXPECT_EQ(back.triangles.size(), mesh.triangles.size());
    ASSERT_EQ(back.elements.size(), mesh.elements.size());
    std::vector<std::size_t> given(mesh.elements.size()), found(mesh.elements.size());
    for (const std::uint32_t e : mesh.triangle_element) ++given[e];
    for (const std::uint32_t e : back.triangle_element) ++found[e];
    EXPECT_EQ(given, found);
    // Lines lie on the same grid, so they end in vertices of the triangles.
    ASSERT_EQ(back.curves.size(), mesh.curves.size());
    std::vector<bool> on_surface(back.positions.size(), false);
    for (const auto& triangle : back.triangles) {
      for (const std::uint32_t corner : triangle) on_surface[corner] = true;
    }
    for (const MeshCurve& curve : back.curves) {
      for (const std::uint32_t v : curve.vertices) EXPECT_TRUE(on_surface[v]);
    }
  }
}

TEST(GltfDraco, KeepsHalfTheToleranceAndTellsTheDeviation) {
  const TriangleMesh mesh = test::die_mesh(24);
  std::size_t last = 0;
  for (const double tolerance : {1.0, 0.1, 0.01, 0.001, 0.0001}) {
    const auto file = kGlb.write(mesh, with_draco(tolerance));
    ASSERT_TRUE(file);
    EXPECT_LE(file->deviation, tolerance / 2);
    const TriangleMesh back = read_back(*file);
    EXPECT_NEAR(farthest(mesh, back), file->deviation, 1e-12);
    EXPECT_GT(file->files[0].bytes.size(), last);  // no more bits than the tolerance asks for
    last = file->files[0].bytes.size();
  }
}

TEST(GltfDraco, BitsAsAsked) {
  const TriangleMesh mesh = test::die_mesh(24);
  WriteOptions options = with_draco(0.01);
  options.quantize_bits = 8;
  const auto coarse = kGlb.write(mesh, options);
  ASSERT_TRUE(coarse);
  EXPECT_GT(coarse->deviation, 0.01);
  EXPECT_LE(coarse->deviation, std::sqrt(3.0) * 61 / 255 / 2);
  ASSERT_EQ(coarse->notes.size(), 1u);
  EXPECT_NE(coarse->notes[0].find("8 bits"), std::string::npos);
  for (const int bits : {0, 25, -3}) {
    options.quantize_bits = bits;
    const auto refused = kGlb.write(mesh, options);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::kUsage);
  }
  EXPECT_EQ(draco_bits(160, 0.005), 15);  // ceil(log2(sqrt(3) * 160 / 0.01 + 1))
  EXPECT_EQ(draco_bits(160, 0), kMostDracoBits);
}

TEST(GltfDraco, EverySpeedHoldsTheSame) {
  const TriangleMesh mesh = test::die_mesh(18, 60, 2);
  for (int speed = 0; speed <= 10; ++speed) {
    WriteOptions options = with_draco(0.01);
    options.draco_speed = speed;
    const auto file = kGlb.write(mesh, options);
    ASSERT_TRUE(file);
    const TriangleMesh back = read_back(*file);
    EXPECT_EQ(back.positions.size(), mesh.positions.size()) << speed;
    EXPECT_EQ(back.triangles.size(), mesh.triangles.size()) << speed;
  }
}

// Degenerate, repeated, non-manifold and turned-round triangles all come back: none is dropped.
TEST(GltfDraco, OddGeometryIsKept) {
  std::mt19937 random(77);
  for (int round = 0; round < 60; ++round) {
    TriangleMesh mesh;
    mesh.unit = LengthUnit::kMillimetre;
    mesh.up = UpAxis::kZ;
    const auto points = static_cast<std::uint32_t>(4 + random() % 30);
    for (std::uint32_t i = 0; i < points; ++i) {
      mesh.positions.emplace_back(static_cast<double>(random() % 1000) / 7, static_cast<double>(i),
                                  static_cast<double>(random() % 1000) / 9);
    }
    const std::size_t triangles = 1 + random() % 60;
    for (std::size_t t = 0; t < triangles; ++t) {
      mesh.triangles.push_back({static_cast<std::uint32_t>(random() % points),
                                static_cast<std::uint32_t>(random() % points),
                                static_cast<std::uint32_t>(random() % points)});
    }
    mesh.triangles.push_back({1, 1, 1});
    const auto file = kGlb.write(mesh, with_draco(0.02));
    ASSERT_TRUE(file);
    EXPECT_LE(file->deviation, 0.01);
    EXPECT_EQ(read_back(*file).triangles.size(), mesh.triangles.size());
  }
}

TEST(GltfDraco, TinyAndHugeMeshes) {
  for (const double size : {1e-4, 1e-2, 1.0, 1e3, 1e6, 1e8}) {
    const TriangleMesh mesh = test::die_mesh(9, size);
    WriteOptions options = with_draco(0);
    const auto file = kGlb.write(mesh, options);
    ASSERT_TRUE(file) << size;
    EXPECT_LE(file->deviation, 1e-5 * std::max(size, 1.0)) << size;
    EXPECT_EQ(read_back(*file).triangles.size(), mesh.triangles.size()) << size;
  }
}

std::vector<std::byte> a_stream(DracoLimits& limits, int speed) {
  const TriangleMesh mesh = test::die_mesh(6);
  std::vector<std::array<float, 3>> points;
  for (const Vec3& p : mesh.positions) {
    points.push_back(
        {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())});
  }
  std::vector<std::uint32_t> numbers(points.size());
  for (std::uint32_t i = 0; i < numbers.size(); ++i) numbers[i] = i;
  DracoSource source;
  source.coordinates = points;
  source.position = numbers;
  source.indices = std::span(mesh.triangles[0].data(), 3 * mesh.triangles.size());
  DracoGrid grid;
  grid.origin = {0, 0, -2};
  grid.range = 64;
  grid.bits = 12;
  const auto blob = encode_draco(source, grid, speed);
  EXPECT_TRUE(blob);
  limits = {mesh.triangles.size(), 3 * mesh.triangles.size()};
  return blob->bytes;
}

TEST(Draco, DamagedStreamsNeverGiveWrongIndices) {
  for (const int speed : {0, 5, 10}) {
    DracoLimits limits;
    const std::vector<std::byte> stream = a_stream(limits, speed);
    const std::array<DracoRequest, 1> position{{{0, 5126, 3}}};
    ASSERT_TRUE(decode_draco(stream, limits, position));
    const auto check = [&](std::span<const std::byte> bytes) {
      const auto decoded = decode_draco(bytes, limits, position);
      if (!decoded) return;
      for (const std::uint32_t corner : decoded->indices) {
        ASSERT_LT(corner, decoded->vertex_count);
      }
      EXPECT_EQ(decoded->attributes[0].size(), 12 * decoded->vertex_count);
    };
    for (std::size_t size = 0; size < stream.size(); ++size) check(std::span(stream).first(size));
    std::vector<std::byte> damaged = stream;
    for (std::size_t bit = 0; bit < 8 * stream.size(); ++bit) {
      damaged[bit / 8] ^= std::byte{1} << (bit % 8);
      check(damaged);
      damaged[bit / 8] = stream[bit / 8];
    }
  }
}

TEST(Draco, CountsThatDifferAreRefused) {
  DracoLimits limits;
  const std::vector<std::byte> stream = a_stream(limits, 3);
  const std::array<DracoRequest, 1> position{{{0, 5126, 3}}};
  EXPECT_FALSE(decode_draco(stream, {limits.triangles + 1, limits.vertices}, position));
  EXPECT_FALSE(decode_draco(stream, {limits.triangles, 3}, position));
  const std::array<DracoRequest, 1> unknown{{{77, 5126, 3}}};
  EXPECT_FALSE(decode_draco(stream, limits, unknown));
  const std::array<DracoRequest, 1> four{{{0, 5126, 4}}};
  EXPECT_FALSE(decode_draco(stream, limits, four));
  const std::array<DracoRequest, 1> shorts{{{0, 5123, 3}}};
  EXPECT_FALSE(decode_draco(stream, limits, shorts));
}

TEST(Draco, StreamsOfOthersAreSurveyed) {
  namespace fs = std::filesystem;
  const fs::path corpus = fs::path(DIESINK_SOURCE_DIR) / "../shared/corpus";
  if (!fs::exists(corpus)) {
    std::puts("skipped: there is no ../shared/corpus");
    GTEST_SKIP();
  }
  const auto bytes_of = [](const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    const std::string text((std::istreambuf_iterator<char>(in)), {});
    std::vector<std::byte> bytes(text.size());
    std::transform(text.begin(), text.end(), bytes.begin(),
                   [](char c) { return static_cast<std::byte>(c); });
    return bytes;
  };
  std::size_t meshes = 0;
  for (const auto& entry : fs::directory_iterator(corpus / "good/glb-draco/drc")) {
    const std::vector<std::byte> bytes = bytes_of(entry.path());
    const bool mesh_of_2_2 = bytes.size() > 8 && bytes[5] == std::byte{2} &&
                             bytes[6] == std::byte{2} && bytes[7] == std::byte{1};
    const auto claims = survey_draco(bytes);
    EXPECT_EQ(static_cast<bool>(claims), mesh_of_2_2)
        << entry.path() << (claims ? "" : claims.error().message);
    if (!claims) continue;
    ++meshes;
    EXPECT_TRUE(decode_draco(bytes, {claims->triangles, 3 * claims->triangles}, {}));
  }
  EXPECT_GE(meshes, 3u);
  for (const auto& entry : fs::directory_iterator(corpus / "bad/crafted/glb-draco/drc")) {
    const std::vector<std::byte> bytes = bytes_of(entry.path());
    const auto claims = survey_draco(bytes);
    if (!claims) continue;
    EXPECT_FALSE(decode_draco(bytes, {claims->triangles, 3 * claims->triangles}, {}))
        << entry.path();
  }
}

}  // namespace
}  // namespace diesink
