// glTF files that are damaged or mean harm: refused or read with a warning, never a crash, a wild
// index or much memory.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>

#include "formats/mesh_file.h"
#include "formats/registry.h"
#include "tests/support/die_mesh.h"

namespace diesink {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using Bytes = std::vector<std::byte>;

Bytes glb_of(const TriangleMesh& mesh, bool draco) {
  WriteOptions options;
  options.draco = draco;
  options.lines = true;
  auto file = kGlb.write(mesh, options);
  EXPECT_TRUE(file);
  return std::move(file->files[0].bytes);
}

Result<TriangleMesh> read(std::span<const std::byte> bytes, Diagnostics& diagnostics,
                          const std::string& folder = {}) {
  ReadOptions options;
  options.file_name = "test.glb";
  options.folder = folder;
  return kGlb.read(bytes, options, diagnostics);
}

// What whoever takes the mesh may rely on.
void expect_sound(const TriangleMesh& mesh) {
  for (const Vec3& p : mesh.positions) ASSERT_TRUE(p.allFinite());
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t corner : triangle) ASSERT_LT(corner, mesh.positions.size());
  }
  if (!mesh.triangle_element.empty()) {
    ASSERT_EQ(mesh.triangle_element.size(), mesh.triangles.size());
    for (const std::uint32_t e : mesh.triangle_element) ASSERT_LT(e, mesh.elements.size());
  }
  if (!mesh.corner_normals.empty()) {
    ASSERT_EQ(mesh.corner_normals.size(), mesh.triangles.size());
    for (const auto& corner : mesh.corner_normals) {
      for (const std::uint32_t n : corner) ASSERT_LT(n, mesh.normals.size());
    }
  }
  ASSERT_TRUE(mesh.vertex_colors.empty() || mesh.vertex_colors.size() == mesh.positions.size());
  for (const MeshCurve& curve : mesh.curves) {
    for (const std::uint32_t v : curve.vertices) ASSERT_LT(v, mesh.positions.size());
    for (const std::uint32_t e : curve.between) {
      ASSERT_TRUE(e == MeshCurve::kNoElement || e < mesh.elements.size());
    }
  }
}

// The JSON of a GLB, and the GLB with another JSON in its place.
Json json_of(const Bytes& glb) {
  std::uint32_t size = 0;
  std::memcpy(&size, &glb[12], 4);
  const char* const begin = reinterpret_cast<const char*>(&glb[20]);
  return Json::parse(begin, begin + size);
}

Bytes with_json(const Bytes& glb, const std::string& json) {
  std::uint32_t old = 0;
  std::memcpy(&old, &glb[12], 4);
  std::string text = json;
  text.resize((text.size() + 3) / 4 * 4, ' ');
  Bytes out(20 + text.size());
  std::memcpy(out.data(), glb.data(), 20);
  std::memcpy(&out[20], text.data(), text.size());
  out.insert(out.end(), glb.begin() + 20 + old, glb.end());
  const std::uint32_t size = static_cast<std::uint32_t>(text.size());
  const std::uint32_t total = static_cast<std::uint32_t>(out.size());
  std::memcpy(&out[12], &size, 4);
  std::memcpy(&out[8], &total, 4);
  return out;
}

Bytes as_bytes(const std::string& text) {
  Bytes out(text.size());
  std::memcpy(out.data(), text.data(), text.size());
  return out;
}

std::string refusal(const Bytes& bytes, const std::string& folder = {}) {
  Diagnostics diagnostics;
  const auto mesh = read(bytes, diagnostics, folder);
  return mesh ? "" : to_text(mesh.error());
}

TEST(GltfHostile, CutAnywhereItIsRefused) {
  for (const bool draco : {false, true}) {
    const Bytes whole = glb_of(test::die_mesh(3), draco);
    for (std::size_t size = 0; size < whole.size(); ++size) {
      Diagnostics diagnostics;
      EXPECT_FALSE(read(std::span(whole).first(size), diagnostics)) << size;
    }
  }
}

// Cut, with the container's lengths set right again: the fault is further inside.
TEST(GltfHostile, CutBuffersAreRefused) {
  const Bytes whole = glb_of(test::die_mesh(3), false);
  std::uint32_t json = 0;
  std::memcpy(&json, &whole[12], 4);
  const std::size_t buffer = 20 + json;
  for (std::size_t size = buffer + 8; size < whole.size(); size += 4) {
    Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    const std::uint32_t total = static_cast<std::uint32_t>(size);
    const std::uint32_t left = static_cast<std::uint32_t>(size - buffer - 8);
    std::memcpy(&cut[8], &total, 4);
    std::memcpy(&cut[buffer], &left, 4);
    EXPECT_NE(refusal(cut), "") << size;
  }
}

TEST(GltfHostile, EveryBitFlipped) {
  for (const bool draco : {false, true}) {
    const Bytes whole = glb_of(test::die_mesh(3), draco);
    Bytes damaged = whole;
    std::uint32_t json = 0;
    std::memcpy(&json, &whole[12], 4);
    for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
      // Of the text one bit a byte: the values are replaced below.
      if (bit / 8 >= 20 && bit / 8 < 20 + json && bit % 8 != (bit / 8) % 7) continue;
      damaged[bit / 8] ^= std::byte{1} << (bit % 8);
      Diagnostics diagnostics;
      const auto mesh = read(damaged, diagnostics);
      if (mesh) expect_sound(*mesh);
      damaged[bit / 8] = whole[bit / 8];
    }
  }
}

// All places of a JSON tree.
void pointers_of(const Json& json, const Json::json_pointer& at,
                 std::vector<Json::json_pointer>& out) {
  out.push_back(at);
  if (json.is_object()) {
    for (const auto& [key, value] : json.items()) pointers_of(value, at / key, out);
  } else if (json.is_array()) {
    for (std::size_t i = 0; i < json.size(); ++i) pointers_of(json[i], at / i, out);
  }
}

TEST(GltfHostile, EveryValueReplaced) {
  const std::vector<Json> replacements{0,
                                       1,
                                       -1,
                                       3,
                                       65535,
                                       4294967295u,
                                       4294967296u,
                                       9223372036854775807,
                                       18446744073709551615u,
                                       0.5,
                                       1e300,
                                       -1e300,
                                       nullptr,
                                       true,
                                       "",
                                       "x",
                                       Json::array(),
                                       Json::object(),
                                       Json::array({0}),
                                       Json::array({0, 0}),
                                       Json::array({nullptr}),
                                       Json::object({{"a", 1}})};
  for (const bool draco : {false, true}) {
    const Bytes whole = glb_of(test::die_mesh(3), draco);
    const Json json = json_of(whole);
    std::vector<Json::json_pointer> places;
    pointers_of(json, Json::json_pointer(), places);
    for (const Json::json_pointer& place : places) {
      for (const Json& replacement : replacements) {
        Json changed = json;
        changed[place] = replacement;
        Diagnostics diagnostics;
        const auto mesh = read(with_json(whole, changed.dump()), diagnostics);
        if (mesh) expect_sound(*mesh);
      }
      if (place.empty()) continue;
      Json changed = json;
      if (changed[place.parent_pointer()].is_object()) {
        changed[place.parent_pointer()].erase(place.back());
      }
      Diagnostics diagnostics;
      const auto mesh = read(with_json(whole, changed.dump()), diagnostics);
      if (mesh) expect_sound(*mesh);
    }
  }
}

// Several parts exchanged at once: values move between places.
TEST(GltfHostile, ValuesExchanged) {
  std::mt19937 random(4711);
  for (const bool draco : {false, true}) {
    const Bytes whole = glb_of(test::die_mesh(3), draco);
    const Json json = json_of(whole);
    std::vector<Json::json_pointer> places;
    pointers_of(json, Json::json_pointer(), places);
    for (int round = 0; round < 4000; ++round) {
      Json changed = json;
      for (int k = 0; k < 1 + round % 4; ++k) {
        const auto& to = places[random() % places.size()];
        const auto& from = places[random() % places.size()];
        if (json.contains(from) && changed.contains(to)) changed[to] = json[from];
      }
      Diagnostics diagnostics;
      const auto mesh = read(with_json(whole, changed.dump()), diagnostics);
      if (mesh) expect_sound(*mesh);
    }
  }
}

TEST(GltfHostile, MessagesNameTheValueAtFault) {
  const Bytes whole = glb_of(test::die_mesh(3), false);
  const auto refused = [&whole](const char* place, const Json& value) {
    Json json = json_of(whole);
    json[Json::json_pointer(place)] = value;
    return refusal(with_json(whole, json.dump()));
  };
  EXPECT_EQ(
      refused("/accessors/0/count", -3),
      "test.glb: error: accessors[0].count is -3, expected a whole number from 1 to 4294967295");
  EXPECT_EQ(refused("/accessors/0/bufferView", 99),
            "test.glb: error: accessors[0].bufferView is 99, expected an index below 3");
  EXPECT_EQ(refused("/asset/version", "1.0"),
            "test.glb: error: asset.version is \"1.0\", expected 2.0");
  EXPECT_EQ(refused("/nodes/1/children", Json::array({1})),
            "test.glb: error: nodes[1] is its own child");
  EXPECT_EQ(refused("/nodes/1/children", Json::array({2})),
            "test.glb: error: nodes[2] is a child of nodes[0] and of nodes[1]");
  EXPECT_EQ(refused("/extensionsRequired", Json::array({"ACME_shape"})),
            "test.glb: error: the file requires the extension ACME_shape, which is not read");
  EXPECT_NE(refused("/bufferViews/1/byteLength", 1e6).find("bufferViews[1] ends at byte"),
            std::string::npos);
  EXPECT_NE(
      refused("/accessors/0/count", 1000).find("accessors[0] has 1000 elements, more than its"),
      std::string::npos);
}

TEST(GltfHostile, SparseIndicesIncrease) {
  // One triangle at the origin, two of its corners replaced: those of the two bytes given in
  // base64.
  const auto file = [](const std::string& numbers) {
    return as_bytes(
        R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
        R"("meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"accessors":[{"bufferView":0,)"
        R"("componentType":5126,"count":3,"type":"VEC3","sparse":{"count":2,"indices":{)"
        R"("bufferView":1,"componentType":5121},"values":{"bufferView":0}}}],"bufferViews":[)"
        R"({"buffer":0,"byteLength":36},{"buffer":1,"byteLength":2}],"buffers":[{"byteLength":36,)"
        R"("uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA"},)"
        R"({"byteLength":2,"uri":"data:application/octet-stream;base64,)" +
        numbers + R"("}]})");
  };
  EXPECT_EQ(refusal(file("AAI=")), "");                                              // 0 2
  EXPECT_NE(refusal(file("AQE=")).find("index 1 behind 1"), std::string::npos);      // 1 1
  EXPECT_NE(refusal(file("AgE=")).find("accessors[0].sparse has index 1 behind 2"),  // 2 1
            std::string::npos)
      << refusal(file("AgE="));
  EXPECT_NE(refusal(file("AQM=")).find("element 3 of 3"), std::string::npos);  // 1 3
}

TEST(GltfHostile, PositionsBeyondAllFloatsAreRefused) {
  const Bytes whole = glb_of(test::die_mesh(3), false);
  for (const double scale : {1e40, 1e300}) {
    Json json = json_of(whole);
    json["nodes"][1]["scale"] = {scale, scale, scale};
    Diagnostics diagnostics;
    const auto mesh = read(with_json(whole, json.dump()), diagnostics, {});
    ASSERT_FALSE(mesh) << scale;
    EXPECT_EQ(mesh.error().code, ErrorCode::kLimit) << to_text(mesh.error());
    EXPECT_NE(to_text(mesh.error()).find("beyond any 32-bit float"), std::string::npos)
        << to_text(mesh.error());
  }
}

TEST(GltfHostile, NestedAndManyValuedJson) {
  std::string deep = R"({"asset":{"version":"2.0"},"extras":)";
  deep += std::string(100'000, '[') + std::string(100'000, ']') + "}";
  EXPECT_NE(refusal(as_bytes(deep)).find("nested deeper than 64"), std::string::npos);
  std::string many = R"({"asset":{"version":"2.0"},"extras":[0)";
  for (int i = 0; i < 2'000'000; ++i) many += ",0";
  EXPECT_NE(refusal(as_bytes(many + "]}")).find("more values than"), std::string::npos);
  std::string nodes = R"({"asset":{"version":"2.0"},"nodes":[{})";
  for (int i = 0; i < 150'000; ++i) nodes += ",{}";
  EXPECT_NE(refusal(as_bytes(nodes + "]}")).find("of its size"), std::string::npos);
  EXPECT_NE(refusal(as_bytes("{\"asset\":{\"version\":\"2.0\",\"x\":1e999}}")), "");
  EXPECT_NE(refusal(as_bytes("{\"asset\":{\"version\":\"2.0\",\"x\":\"\xFF\"}}")), "");
}

// One small accessor drawn many times over.
TEST(GltfHostile, AmplifiedScenesAreLimited) {
  const Bytes whole = glb_of(test::die_mesh(12), false);
  Json json = json_of(whole);
  for (int i = 0; i < 50'000; ++i) {
    json["scenes"][0]["nodes"].push_back(json["nodes"].size());
    json["nodes"].push_back({{"mesh", 0}});
  }
  EXPECT_NE(refusal(with_json(whole, json.dump())).find("of its size may hold"), std::string::npos);
  // Positions out of nothing: an accessor without a view is all zeros.
  json = json_of(whole);
  json["accessors"].push_back(
      {{"componentType", 5126}, {"count", 4'000'000'000u}, {"type", "VEC3"}});
  json["meshes"][0]["primitives"][0] = {
      {"attributes", {{"POSITION", json["accessors"].size() - 1}}}};
  EXPECT_NE(refusal(with_json(whole, json.dump())), "");
}

TEST(GltfHostile, BuffersStayInTheirFolder) {
  std::string pattern = (fs::temp_directory_path() / "diesink_gltf_XXXXXX").string();
  ASSERT_NE(mkdtemp(pattern.data()), nullptr);
  const fs::path top = pattern;
  const fs::path folder = top / "in";
  fs::create_directories(folder / "sub");
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  WriteOptions options;
  options.file_stem = "part";
  const auto files = kGltf.write(mesh, options);
  ASSERT_TRUE(files);
  const std::string text(reinterpret_cast<const char*>(files->files[0].bytes.data()),
                         files->files[0].bytes.size());
  for (const fs::path& path :
       {folder / "part.bin", folder / "a b%.bin", folder / "sub/part.bin", top / "part.bin"}) {
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(files->files[1].bytes.data()),
               static_cast<std::streamsize>(files->files[1].bytes.size()));
  }
  fs::create_symlink(top / "part.bin", folder / "link.bin");
  fs::create_symlink(folder / "part.bin", folder / "inner.bin");
  ASSERT_EQ(mkfifo((folder / "pipe.bin").c_str(), 0600), 0);
  const auto answer = [&](const std::string& uri) {
    Json json = Json::parse(text);
    json["buffers"][0]["uri"] = uri;
    return refusal(as_bytes(json.dump()), folder.string());
  };
  EXPECT_EQ(answer("part.bin"), "");
  EXPECT_EQ(answer("./part.bin"), "");
  EXPECT_EQ(answer("sub/part.bin"), "");
  EXPECT_EQ(answer("a%20b%25.bin"), "");
  EXPECT_EQ(answer("inner.bin"), "");
  for (const std::string& uri : {std::string("../part.bin"),
                                 std::string("%2e%2e/part.bin"),
                                 std::string("sub/../../part.bin"),
                                 std::string("..\\part.bin"),
                                 (top / "part.bin").string(),
                                 std::string("file:///etc/passwd"),
                                 std::string("/etc/passwd"),
                                 std::string("/dev/zero"),
                                 std::string("link.bin"),
                                 std::string("pipe.bin"),
                                 std::string("sub"),
                                 std::string("."),
                                 std::string(""),
                                 std::string("part%00.bin"),
                                 std::string("part.bi%"),
                                 std::string("missing.bin"),
                                 std::string("http://example.com/part.bin"),
                                 std::string("data:,AAAA"),
                                 std::string("data:application/octet-stream;base64,AAAA"),
                                 std::string("data:application/octet-stream;base64,!!!!")}) {
    EXPECT_NE(answer(uri), "") << uri;
  }
  fs::remove_all(top);
}

// The corpus beside the project: what must be accepted with its triangles, and what must not pass
// without a word.
class Corpus : public ::testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::path(DIESINK_SOURCE_DIR) / "../shared/corpus";
    if (!fs::exists(root_ / "MANIFEST.tsv")) {
      std::puts("skipped: there is no ../shared/corpus");
      GTEST_SKIP();
    }
    std::ifstream in(root_ / "MANIFEST.tsv");
    for (std::string line; std::getline(in, line);) {
      std::vector<std::string> fields;
      std::istringstream parts(line);
      for (std::string field; std::getline(parts, field, '\t');) fields.push_back(field);
      if (fields.size() < 5) continue;
      const std::string ending = fs::path(fields[0]).extension().string();
      if (ending == ".gltf" || ending == ".glb") rows_.push_back(fields);
    }
  }
  fs::path root_;
  std::vector<std::vector<std::string>> rows_;
};

TEST_F(Corpus, GoodFilesHaveTheirTriangles) {
  std::size_t seen = 0;
  for (const auto& row : rows_) {
    if (!row[0].starts_with("good/")) continue;
    Diagnostics diagnostics;
    const auto file = read_mesh_file((root_ / row[0]).string(), {}, diagnostics);
    ASSERT_TRUE(file) << row[0] << ": " << file.error().message;
    if (row[4] != "?") {
      EXPECT_EQ(file->mesh.triangles.size(), std::stoul(row[4])) << row[0];
    }
    expect_sound(file->mesh);
    ++seen;
  }
  EXPECT_GE(seen, 25u);
}

TEST_F(Corpus, BadFilesAreRefusedOrToldOf) {
  // Legal after all: by name, many instances, or an empty chunk, which the format allows.
  const auto legal = [](const std::string& name) {
    return name.find("_VALID") != std::string::npos ||
           name.find("mesh_instances_20000") != std::string::npos ||
           name.find("zero-sized-bin-chunk") != std::string::npos;
  };
  std::size_t seen = 0;
  for (const auto& row : rows_) {
    if (!row[0].starts_with("bad/")) continue;
    Diagnostics diagnostics;
    ReadOptions options;
    options.file_name = (root_ / row[0]).string();
    options.folder = (root_ / row[0]).parent_path().string();
    std::ifstream in(options.file_name, std::ios::binary);
    const std::string text((std::istreambuf_iterator<char>(in)), {});
    const auto mesh = kGlb.read(as_bytes(text), options, diagnostics);
    ++seen;
    if (!mesh) continue;
    expect_sound(*mesh);
    if (legal(row[0])) {
      EXPECT_FALSE(mesh->triangles.empty()) << row[0];
    } else {
      EXPECT_FALSE(diagnostics.all().empty()) << row[0];
    }
  }
  EXPECT_GE(seen, 250u);
#ifndef __SANITIZE_ADDRESS__
  // All of them together, this program and its libraries included.
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  EXPECT_LT(used.ru_maxrss, 300 * 1024);
#endif
}

TEST_F(Corpus, WhatIsNoJsonIsRefused) {
  std::size_t seen = 0;
  for (const auto& entry : fs::directory_iterator(root_ / "bad/json")) {
    std::ifstream in(entry.path(), std::ios::binary);
    const std::string text((std::istreambuf_iterator<char>(in)), {});
    // As a file of its own, and as a part of one that is well but for it.
    EXPECT_NE(refusal(as_bytes(text)), "") << entry.path();
    const std::string inside = R"({"asset":{"version":"2.0"},"extras":)" + text + "}";
    if (entry.path().filename().string().starts_with("n_")) {
      // Some are whole documents with something after them, or break off: wrapped they may be well.
      const bool was_json = Json::accept(inside);
      EXPECT_TRUE(was_json || !refusal(as_bytes(inside)).empty()) << entry.path();
    }
    ++seen;
  }
  EXPECT_GE(seen, 150u);
}

}  // namespace
}  // namespace diesink
