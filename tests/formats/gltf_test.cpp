// glTF and GLB written and read back.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <random>

#include "formats/glb_container.h"
#include "formats/registry.h"
#include "tests/support/die_mesh.h"

namespace diesink {
namespace {

WrittenMesh written(const Format& format, const TriangleMesh& mesh, const WriteOptions& options) {
  auto result = format.write(mesh, options);
  EXPECT_TRUE(result) << result.error().message;
  return result ? std::move(*result) : WrittenMesh{};
}

TriangleMesh read_back(const Format& format, const std::vector<std::byte>& bytes,
                       std::size_t warnings = 0) {
  Diagnostics diagnostics;
  ReadOptions options;
  options.file_name = "test.glb";
  auto mesh = format.read(bytes, options, diagnostics);
  EXPECT_TRUE(mesh) << mesh.error().message;
  for (const Diagnostic& d : diagnostics.all()) {
    EXPECT_LE(diagnostics.all().size(), warnings) << d.message;
  }
  return mesh ? std::move(*mesh) : TriangleMesh{};
}

// Rounded to floats as the file has them, so that everything can come back to the bit.
TriangleMesh in_floats(TriangleMesh mesh) {
  for (Vec3& p : mesh.positions) p = p.cast<float>().cast<double>();
  for (Vec3& n : mesh.normals) n = n.cast<float>().cast<double>();
  return mesh;
}

// A triangle by what it looks like: element name, corners and their normals, beginning with the
// least corner.
using Corner = std::array<double, 6>;
std::multimap<std::string, std::array<Corner, 3>> looks(const TriangleMesh& mesh) {
  std::multimap<std::string, std::array<Corner, 3>> all;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    std::array<Corner, 3> triangle{};
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& p = mesh.positions[mesh.triangles[t][k]];
      const Vec3 n = mesh.normals.empty() ? Vec3(0, 0, 0) : mesh.normals[mesh.corner_normals[t][k]];
      triangle[k] = {p.x(), p.y(), p.z(), n.x(), n.y(), n.z()};
    }
    std::rotate(triangle.begin(), std::min_element(triangle.begin(), triangle.end()),
                triangle.end());
    const std::string name =
        mesh.triangle_element.empty() ? "" : mesh.elements[mesh.triangle_element[t]].name;
    all.emplace(name, triangle);
  }
  return all;
}

std::vector<std::pair<std::string, std::array<Corner, 3>>> sorted_looks(const TriangleMesh& mesh) {
  const auto all = looks(mesh);
  std::vector<std::pair<std::string, std::array<Corner, 3>>> list(all.begin(), all.end());
  std::sort(list.begin(), list.end());
  return list;
}

void expect_same(const TriangleMesh& a, const TriangleMesh& b) {
  EXPECT_EQ(sorted_looks(a), sorted_looks(b));
  EXPECT_EQ(a.positions.size(), b.positions.size());
  EXPECT_EQ(a.unit, b.unit);
  EXPECT_EQ(a.up, b.up);
  EXPECT_EQ(a.name, b.name);
  ASSERT_EQ(a.elements.size(), b.elements.size());
  for (std::size_t e = 0; e < a.elements.size(); ++e) {
    EXPECT_EQ(a.elements[e].name, b.elements[e].name);
    EXPECT_EQ(a.elements[e].solid, b.elements[e].solid);
    EXPECT_EQ(a.elements[e].color, b.elements[e].color);
  }
}

void expect_same_curves(const TriangleMesh& a, const TriangleMesh& b) {
  ASSERT_EQ(a.curves.size(), b.curves.size());
  for (std::size_t c = 0; c < a.curves.size(); ++c) {
    EXPECT_EQ(a.curves[c].kind, b.curves[c].kind);
    EXPECT_EQ(a.curves[c].between, b.curves[c].between);
    EXPECT_EQ(a.curves[c].closed, b.curves[c].closed);
    EXPECT_EQ(a.curves[c].name, b.curves[c].name);
    ASSERT_EQ(a.curves[c].vertices.size(), b.curves[c].vertices.size());
    for (std::size_t v = 0; v < a.curves[c].vertices.size(); ++v) {
      EXPECT_EQ(a.positions[a.curves[c].vertices[v]], b.positions[b.curves[c].vertices[v]]);
    }
  }
}

TEST(Gltf, GlbComesBackToTheBit) {
  WriteOptions options;
  options.lines = true;
  for (const Vec3& at : {Vec3(0, 0, 0), Vec3(1000, 0, -500), Vec3(4e5, -7e5, 1234.5)}) {
    const TriangleMesh mesh = in_floats(test::die_mesh(12, 60, 2, at));
    const WrittenMesh file = written(kGlb, mesh, options);
    ASSERT_EQ(file.files.size(), 1u);
    EXPECT_EQ(file.deviation, 0);
    const TriangleMesh back = read_back(kGlb, file.files[0].bytes);
    expect_same(mesh, back);
    expect_same_curves(mesh, back);
  }
}

TEST(Gltf, DoublesFarAwayKeepTheirPrecision) {
  const TriangleMesh mesh = test::die_mesh(12, 60, 0, Vec3(4e5, -7e5, 1234.5));
  const WrittenMesh file = written(kGlb, mesh, {});
  // As near as floats of the part's own size can be, not of its distance.
  EXPECT_GT(file.deviation, 0);
  EXPECT_LT(file.deviation, 1e-5);
  const TriangleMesh back = read_back(kGlb, file.files[0].bytes);
  double worst = 0;
  for (const Vec3& p : mesh.positions) {
    double nearest = 1e9;
    for (const Vec3& q : back.positions) nearest = std::min(nearest, (p - q).norm());
    worst = std::max(worst, nearest);
  }
  EXPECT_NEAR(worst, file.deviation, 1e-12);
}

TEST(Gltf, UnitsAxesAndColoursComeBack) {
  for (const LengthUnit unit : {LengthUnit::kUnknown, LengthUnit::kMillimetre,
                                LengthUnit::kCentimetre, LengthUnit::kMetre, LengthUnit::kInch}) {
    for (const UpAxis up : {UpAxis::kUnknown, UpAxis::kY, UpAxis::kZ}) {
      TriangleMesh mesh = in_floats(test::die_mesh(6));
      mesh.unit = unit;
      mesh.up = up;
      const WrittenMesh file = written(kGlb, mesh, {});
      expect_same(mesh, read_back(kGlb, file.files[0].bytes));
    }
  }
  TriangleMesh colored = in_floats(test::die_mesh(18));
  for (std::size_t v = 0; v < colored.positions.size(); ++v) {
    const auto shade = static_cast<std::uint8_t>(v);
    colored.vertex_colors.push_back({shade, static_cast<std::uint8_t>(255 - shade), 7, shade});
  }
  const TriangleMesh back = read_back(kGlb, written(kGlb, colored, {}).files[0].bytes);
  expect_same(colored, back);
  ASSERT_EQ(back.vertex_colors.size(), back.positions.size());
  for (std::size_t v = 0; v < back.positions.size(); ++v) {
    const auto at =
        std::find(colored.positions.begin(), colored.positions.end(), back.positions[v]);
    ASSERT_NE(at, colored.positions.end());
    EXPECT_EQ(back.vertex_colors[v],
              colored.vertex_colors[static_cast<std::size_t>(at - colored.positions.begin())]);
  }
}

TEST(Gltf, MeshesWithoutNamesNormalsOrTriangles) {
  TriangleMesh bare;
  bare.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  bare.triangles = {{0, 1, 2}};
  expect_same(bare, read_back(kGlb, written(kGlb, bare, {}).files[0].bytes));
  const TriangleMesh empty;
  expect_same(empty, read_back(kGlb, written(kGlb, empty, {}).files[0].bytes, 1));
}

TEST(Gltf, WithoutAStemTheBufferIsInTheText) {
  const TriangleMesh mesh = in_floats(test::die_mesh());
  const WrittenMesh file = written(kGltf, mesh, {});
  ASSERT_EQ(file.files.size(), 1u);
  expect_same(mesh, read_back(kGltf, file.files[0].bytes));
}

TEST(Gltf, TheSameMeshGivesTheSameBytes) {
  WriteOptions options;
  options.lines = true;
  options.draco = true;
  const TriangleMesh mesh = test::die_mesh(20, 60, 3);
  EXPECT_EQ(written(kGlb, mesh, options).files[0].bytes,
            written(kGlb, mesh, options).files[0].bytes);
}

TEST(Gltf, ExtrasStandInTheAsset) {
  WriteOptions options;
  options.extras_json = R"({"report":{"triangles":320}})";
  const WrittenMesh file = written(kGlb, test::die_mesh(), options);
  const std::string text(reinterpret_cast<const char*>(file.files[0].bytes.data()),
                         file.files[0].bytes.size());
  EXPECT_NE(text.find(R"("extras":{"report":{"triangles":320}})"), std::string::npos);
  options.extras_json = "{";
  const auto refused = kGlb.write(test::die_mesh(), options);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kUsage);
}

TEST(Gltf, AGlbEndsAtFourGibibytesAndSaysWhy) {
  constexpr std::uint64_t kMost = 0xFFFFFFFFu;
  const Result<std::uint32_t> small = glb_size(100, 8);
  ASSERT_TRUE(small);
  EXPECT_EQ(*small, 12 + 8 + 100 + 8 + 8);
  EXPECT_EQ(*glb_size(100, 0), 12 + 8 + 100);
  const Result<std::uint32_t> largest = glb_size(1000, kMost - 1028);
  ASSERT_TRUE(largest);
  EXPECT_EQ(*largest, kMost);
  for (const std::uint64_t buffer : {kMost - 1027, kMost, kMost + 1000, kMost * 4096}) {
    const Result<std::uint32_t> over = glb_size(1000, buffer);
    ASSERT_FALSE(over) << buffer;
    EXPECT_EQ(over.error().code, ErrorCode::kUnsupported);
    EXPECT_EQ(over.error().message, "a GLB holds at most 4294967295 bytes and this mesh needs " +
                                        std::to_string(buffer + 1028) +
                                        "; write .gltf, .ply or .stl");
  }
}

// Elements whose vertices are a run of the mesh's are written as they stand; others are not.
TEST(Gltf, ElementsOfARunOfVerticesAndOthers) {
  TriangleMesh mesh;
  for (int i = 0; i < 12; ++i) mesh.positions.emplace_back(i % 2, i / 2, 0.25 * i);
  mesh.triangles = {{0, 1, 2},  {1, 3, 2}, {2, 3, 4}, {3, 5, 4},  // a run from 0
                    {4, 5, 6},  {5, 7, 6},                        // a run from 4
                    {8, 9, 11},                                   // 10 is nobody's
                    {0, 2, 9}};                                   // all over
  mesh.triangle_element = {0, 0, 0, 0, 1, 1, 2, 3};
  for (const char* name : {"a", "b", "c", "d"}) mesh.elements.push_back({name, "", {}});
  for (const int way : {0, 1, 2, 3}) {
    TriangleMesh each = mesh;
    if (way > 0) {
      for (int i = 0; i < 12; ++i) each.normals.push_back(Vec3(i, 1, 2).normalized());
      each.corner_normals = each.triangles;
    }
    if (way == 2) each.corner_normals[1][2] = 7;  // normals of their own in the first
    if (way == 3) std::swap(each.triangles[0], each.triangles[5]);  // no longer in order
    each = in_floats(each);
    const WrittenMesh file = written(kGlb, each, {});
    EXPECT_EQ(looks(read_back(kGlb, file.files[0].bytes, 1)), looks(each)) << way;
    ASSERT_EQ(file.notes.size(), 1U) << way;
    EXPECT_EQ(file.notes[0], "1 vertex that belongs to no triangle is left out");
  }
}

TEST(Gltf, WrongMeshesAreRefused) {
  TriangleMesh mesh = test::die_mesh();
  mesh.positions[3].x() = std::nan("");
  EXPECT_FALSE(kGlb.write(mesh, {}));
  mesh = test::die_mesh();
  mesh.triangles[5][1] = 1'000'000;
  EXPECT_FALSE(kGlb.write(mesh, {}));
  mesh = test::die_mesh();
  mesh.corner_normals[5][1] = 1'000'000;
  EXPECT_FALSE(kGlb.write(mesh, {}));
  for (const std::size_t triangle : {std::size_t{0}, mesh.triangles.size() - 1}) {
    mesh = test::die_mesh();  // its triangles are in the order of their elements, or no longer
    mesh.triangle_element[triangle] = static_cast<std::uint32_t>(mesh.elements.size());
    const auto refused = kGlb.write(mesh, {});
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("belongs to element 3 of 3"), std::string::npos)
        << refused.error().message;
  }
  mesh = test::die_mesh();
  mesh.curves[0].vertices[0] = 1'000'000;
  WriteOptions options;
  options.lines = true;
  EXPECT_FALSE(kGlb.write(mesh, options));
}

TEST(Gltf, VerticesLeftOutAreTold) {
  TriangleMesh mesh = test::die_mesh(6);
  mesh.positions.insert(mesh.positions.end(), 3, Vec3(1, 2, 3));
  mesh.curves[1].vertices.push_back(static_cast<std::uint32_t>(mesh.positions.size() - 1));
  WriteOptions options;
  EXPECT_EQ(written(kGlb, mesh, options).notes,
            std::vector<std::string>{"3 vertices that belong to no triangle are left out"});
  options.lines = true;
  EXPECT_EQ(written(kGlb, mesh, options).notes,
            std::vector<std::string>{"2 vertices that belong to no triangle are left out"});
}

// A file of one buffer, in base64: six points of a strip 0 .. 5 over the plane z = 0, and byte
// indices.
//   1--3--5
//   |  |  |      at x = 0, 1, 2 and y = 0, 1
//   0--2--4
constexpr const char* kStrip =
    R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[NODES]}],"nodes":[
{"mesh":0,"name":"a"},{"mesh":0,"scale":[1,1,-1],"translation":[0,0,5]},{"children":[3],"scale":[2,2,2]},{"mesh":0}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},INDICES"mode":MODE}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":6,"type":"VEC3","min":[0,0,0],"max":[2,1,0]},
{"bufferView":1,"componentType":5121,"count":4,"type":"SCALAR"}],
"bufferViews":[{"buffer":0,"byteLength":72},{"buffer":0,"byteOffset":72,"byteLength":4}],
"buffers":[{"byteLength":76,"uri":"data:application/octet-stream;base64,)"
    "AAAAAAAAAAAAAAAAAAAAAAAAgD8AAAAAAACAPwAAAAAAAAAAAACAPwAAgD8AAAAAAAAAQAAAAAAAAAAA"
    "AAAAQAAAgD8AAAAABQQCAA=="
    R"("}]})";

TriangleMesh strip_of(const std::string& nodes, const std::string& indices,
                      const std::string& mode) {
  std::string text = kStrip;
  const auto put = [&text](const std::string& word, const std::string& value) {
    text.replace(text.find(word), word.size(), value);
  };
  put("NODES", nodes);
  put("INDICES", indices);
  put("MODE", mode);
  std::vector<std::byte> bytes(text.size());
  std::memcpy(bytes.data(), text.data(), text.size());
  return read_back(kGltf, bytes, 4);
}

// Twice the area seen from above, and the corners of each triangle by x + 10 y.
double twice_area(const TriangleMesh& mesh) {
  double area = 0;
  for (const auto& t : mesh.triangles) {
    const Vec3 a = mesh.positions[t[1]] - mesh.positions[t[0]];
    const Vec3 b = mesh.positions[t[2]] - mesh.positions[t[0]];
    area += a.x() * b.y() - a.y() * b.x();
  }
  return area;
}

TEST(Gltf, StripsFansListsAndLines) {
  const TriangleMesh strip = strip_of("0", "", "5");
  EXPECT_EQ(strip.triangles.size(), 4u);
  EXPECT_EQ(strip.positions.size(), 6u);
  EXPECT_EQ(twice_area(strip), -4);  // 0 1 2 turns downward, and all others with it
  EXPECT_EQ(strip.unit, LengthUnit::kMetre);
  EXPECT_EQ(strip.up, UpAxis::kY);
  ASSERT_EQ(strip.elements.size(), 1u);
  EXPECT_EQ(strip.elements[0].name, "a");
  const TriangleMesh indexed = strip_of("0", R"("indices":1,)", "5");
  EXPECT_EQ(indexed.triangles.size(), 2u);
  EXPECT_EQ(indexed.triangles[0].size(), 3u);
  // Indices 5 4 2 0: the fan about 5.
  const TriangleMesh fan = strip_of("0", R"("indices":1,)", "6");
  EXPECT_EQ(fan.triangles.size(), 2u);
  EXPECT_EQ(twice_area(fan), -2);
  EXPECT_EQ(strip_of("0", "", "4").triangles.size(), 2u);
  const TriangleMesh loop = strip_of("0", R"("indices":1,)", "2");
  ASSERT_EQ(loop.curves.size(), 1u);
  EXPECT_TRUE(loop.curves[0].closed);
  EXPECT_EQ(loop.curves[0].vertices.size(), 4u);
  const TriangleMesh line = strip_of("0", R"("indices":1,)", "3");
  ASSERT_EQ(line.curves.size(), 1u);
  EXPECT_FALSE(line.curves[0].closed);
  const TriangleMesh pairs = strip_of("0", R"("indices":1,)", "1");
  ASSERT_EQ(pairs.curves.size(), 2u);  // 5-4 and 2-0 do not meet
  EXPECT_EQ(strip_of("0", "", "0").triangles.size(), 0u);
}

TEST(Gltf, NodesPlaceScaleAndMirror) {
  const TriangleMesh scaled = strip_of("2", "", "5");
  EXPECT_EQ(twice_area(scaled), -16);
  const TriangleMesh two = strip_of("0,1", "", "5");
  EXPECT_EQ(two.triangles.size(), 8u);
  EXPECT_EQ(two.positions.size(), 12u);  // parts that do not share a mesh stay apart
  ASSERT_EQ(two.elements.size(), 2u);
  EXPECT_NE(two.elements[0].name, two.elements[1].name);
  // Mirrored in z: the outside of a triangle stays outside, so its sense seen from above turns.
  EXPECT_EQ(twice_area(strip_of("1", "", "5")), 4);
  EXPECT_EQ(strip_of("1", "", "5").positions[0].z(), 5);
}

// Random soups: any sharing, any elements, any normals.
TEST(Gltf, RandomMeshesComeBack) {
  std::mt19937 random(20240817);
  const auto below = [&random](std::size_t n) { return static_cast<std::uint32_t>(random() % n); };
  for (int round = 0; round < 60; ++round) {
    TriangleMesh mesh;
    mesh.unit = round % 2 == 0 ? LengthUnit::kInch : LengthUnit::kMillimetre;
    mesh.up = UpAxis::kZ;
    mesh.name = "random";
    std::map<std::array<float, 3>, int> seen;
    const std::size_t points = 3 + below(80);
    for (std::size_t i = 0; i < points; ++i) {
      std::array<float, 3> p{};
      do {
        for (float& x : p) x = static_cast<float>(below(2000)) * 0.37f - 300.f;
      } while (!seen.emplace(p, 1).second);
      mesh.positions.push_back(
          {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])});
    }
    const std::size_t elements = 1 + below(5);
    for (std::size_t e = 0; e < elements; ++e) {
      mesh.elements.push_back({"E" + std::to_string(e), "S", {}});
    }
    for (int n = 0; n < 8; ++n) {
      const Vec3 v(below(100) + 1.0, below(100), below(100));
      mesh.normals.push_back(v.normalized().cast<float>().cast<double>());
    }
    std::vector<bool> used(points, false);
    const std::size_t triangles = 1 + below(150);
    for (std::size_t t = 0; t < triangles; ++t) {
      const std::uint32_t a = below(points);
      const std::uint32_t b = (a + 1 + below(points - 1)) % static_cast<std::uint32_t>(points);
      std::uint32_t c = a;
      while (c == a || c == b) c = below(points);
      mesh.triangles.push_back({a, b, c});
      mesh.corner_normals.push_back({below(8), below(8), below(8)});
      mesh.triangle_element.push_back(below(elements));
      used[a] = used[b] = used[c] = true;
    }
    const TriangleMesh back = read_back(kGlb, written(kGlb, mesh, {}).files[0].bytes);
    EXPECT_EQ(sorted_looks(mesh), sorted_looks(back));
    EXPECT_EQ(back.positions.size(),
              static_cast<std::size_t>(std::count(used.begin(), used.end(), true)));
  }
}

}  // namespace
}  // namespace diesink
