// What goes into the viewer's pages; the pages themselves are for tests/convert/view_test.py.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "viewer/packed_arrays.h"
#include "viewer/scene.h"
#include "viewer/smooth_normals.h"

namespace diesink {
namespace {

// The numbers of one array that "delta" has coded, by the rule of the header.
std::vector<std::int32_t> unpacked(const PackedArrays& arrays, std::size_t count,
                                   std::size_t components) {
  const std::size_t size = count * components, planes = arrays.bytes().size() / size;
  std::vector<std::int32_t> values(size);
  for (std::size_t c = 0; c < components; ++c) {
    std::uint32_t value = 0;
    for (std::size_t k = 0; k < count; ++k) {
      std::uint32_t code = 0;
      for (std::size_t p = 0; p < planes; ++p) {
        code |= std::uint32_t{arrays.bytes()[p * size + c * count + k]} << (8 * p);
      }
      value += (code >> 1) ^ ((code & 1) != 0 ? 0xFFFFFFFFU : 0U);
      values[k * components + c] = static_cast<std::int32_t>(value);
    }
  }
  return values;
}

TEST(PackedArrays, ExtremesComeBack) {
  constexpr std::int32_t kLow = std::numeric_limits<std::int32_t>::min();
  constexpr std::int32_t kHigh = std::numeric_limits<std::int32_t>::max();
  const std::vector<std::int32_t> values{0, kLow, kHigh, kHigh, kLow, -1, 1, kHigh, 0, -7};
  PackedArrays arrays;
  arrays.add("a", values, 2);
  EXPECT_EQ(unpacked(arrays, 5, 2), values);
}

TEST(PackedArrays, OnlyBytesThatAreNeeded) {
  PackedArrays arrays;
  arrays.add("zero", std::vector<std::int32_t>{0, 0, 0}, 3);
  arrays.add("none", {}, 3);
  EXPECT_TRUE(arrays.bytes().empty());
  arrays.add("steps", std::vector<std::int32_t>{100, 200, 300}, 1);
  EXPECT_EQ(arrays.bytes().size(), 3U);
  // Each index but the second 0 is a new one.
  arrays.add_indices("index", std::vector<std::uint32_t>{0, 1, 2, 2, 1, 3});
  EXPECT_EQ(arrays.bytes().size(), 9U);
}

TEST(Base64, EveryLengthOfTheEnd) {
  const auto of = [](std::string_view text) {
    return base64({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  };
  EXPECT_EQ(of(""), "");
  EXPECT_EQ(of("f"), "Zg==");
  EXPECT_EQ(of("fo"), "Zm8=");
  EXPECT_EQ(of("foobar"), "Zm9vYmFy");
  EXPECT_EQ(of("\xff\xfb"), "//s=");
}

TEST(SceneQuantum, IsAPowerOfTenWithinItsBounds) {
  EXPECT_DOUBLE_EQ(scene_quantum(38, 0.02), 1e-4);
  EXPECT_DOUBLE_EQ(scene_quantum(38, 0.01), 1e-4);
  EXPECT_DOUBLE_EQ(scene_quantum(160, 0), 1e-4);
  EXPECT_DOUBLE_EQ(scene_quantum(1e6, 1e-9), 0.1);  // what floats and 31 bits hold
  for (const double extent : {1e-6, 0.3, 7.0, 99.0, 2e9}) {
    for (const double tolerance : {0.0, 1e-12, 1e-3, 1.0}) {
      EXPECT_LT(extent / scene_quantum(extent, tolerance), 1 << 30) << extent << " " << tolerance;
    }
  }
  EXPECT_GT(scene_quantum(0, 0), 0);
}

// A prism of `sides` around the z axis, without its ends.
TriangleMesh prism(std::uint32_t sides) {
  TriangleMesh mesh;
  for (std::uint32_t k = 0; k < sides; ++k) {
    const double angle = 2 * std::numbers::pi * k / sides;
    mesh.positions.emplace_back(std::cos(angle), std::sin(angle), 0);
    mesh.positions.emplace_back(std::cos(angle), std::sin(angle), 1);
    const std::uint32_t a = 2 * k, b = 2 * ((k + 1) % sides);
    mesh.triangles.push_back({a, b, b + 1});
    mesh.triangles.push_back({a, b + 1, a + 1});
  }
  return mesh;
}

TEST(SmoothNormals, BlendOverBluntEdgesOnly) {
  TriangleMesh round = prism(36), sharp = prism(6);
  smooth_normals(round, 30);
  smooth_normals(sharp, 30);
  for (std::size_t t = 0; t < round.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& p = round.positions[round.triangles[t][k]];
      EXPECT_LT((round.normals[round.corner_normals[t][k]] - Vec3(p.x(), p.y(), 0)).norm(), 1e-12);
    }
  }
  for (std::size_t t = 0; t < sharp.triangles.size(); ++t) {
    const auto& [a, b, c] = sharp.triangles[t];
    const Vec3 flat = (sharp.positions[b] - sharp.positions[a])
                          .cross(sharp.positions[c] - sharp.positions[a])
                          .normalized();
    for (const std::uint32_t n : sharp.corner_normals[t]) {
      EXPECT_LT((sharp.normals[n] - flat).norm(), 1e-12);
    }
  }
}

TEST(SmoothNormals, ElementsAreNotBlended) {
  TriangleMesh mesh = prism(36);
  mesh.elements.resize(2);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    mesh.triangle_element.push_back(t < 36 ? 0 : 1);
  }
  smooth_normals(mesh, 30);
  // At the border of the halves each has its own triangle's normal.
  EXPECT_GT((mesh.normals[mesh.corner_normals[0][0]] - Vec3::UnitX()).norm(), 0.05);
}

TEST(SmoothNormals, AFanOfManyTrianglesAndTrianglesWithoutAreaEnd) {
  TriangleMesh mesh;
  constexpr std::uint32_t kMany = 200'000;
  mesh.positions.emplace_back(0, 0, 0);
  for (std::uint32_t k = 0; k < kMany; ++k) {
    const double angle = 2 * std::numbers::pi * k / kMany;
    mesh.positions.emplace_back(std::cos(angle), std::sin(angle), 0);
    mesh.triangles.push_back({0, 1 + k, 1 + (k + 1) % kMany});
  }
  mesh.triangles.push_back({0, 1, 1});
  smooth_normals(mesh, 30);
  EXPECT_LT((mesh.normals[mesh.corner_normals[7][0]] - Vec3::UnitZ()).norm(), 1e-9);
}

TEST(ViewerPage, ASceneOfNothingIsRefused) {
  const Result<std::string> page = viewer_page_of(Scene{});
  ASSERT_FALSE(page);
  EXPECT_EQ(page.error().code, can_view() ? ErrorCode::kInput : ErrorCode::kUnsupported);
}

}  // namespace
}  // namespace diesink
