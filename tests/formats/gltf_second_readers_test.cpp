// Independent programs read what we write, and we read what they write: the Khronos validator,
// glTF-Transform with draco3d and meshoptimizer, all from npm (tests/formats/npm, `npm ci`).
// Without them these tests say so and skip.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "formats/gltf_root.h"
#include "formats/mesh_file.h"

namespace diesink {
namespace {

namespace fs = std::filesystem;

const fs::path kNpm = fs::path(DIESINK_SOURCE_DIR) / "tests/formats/npm";

std::string quoted(const fs::path& path) { return "'" + path.string() + "'"; }

std::string output_of(const std::string& command) {
  std::string text;
  FILE* const pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return text;
  std::array<char, 4096> part{};
  while (const std::size_t got = fread(part.data(), 1, part.size(), pipe))
    text.append(part.data(), got);
  pclose(pipe);
  return text;
}

class SecondReaders : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists(kNpm / "node_modules") || std::system("node --version >/dev/null 2>&1") != 0) {
      std::puts("skipped: tests/formats/npm is not installed (npm ci)");
      GTEST_SKIP();
    }
    std::string pattern = (fs::temp_directory_path() / "diesink_gltf_XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
    ASSERT_EQ(std::system((std::string(DIESINK_GLTF_SAMPLES) + " " + quoted(folder_)).c_str()), 0);
  }
  void TearDown() override {
    if (!folder_.empty()) fs::remove_all(folder_);
  }

  static TriangleMesh read(const fs::path& path) {
    Diagnostics diagnostics;
    auto file = read_mesh_file(path.string(), {}, diagnostics);
    EXPECT_TRUE(file) << path << ": " << file.error().message;
    return file ? std::move(file->mesh) : TriangleMesh{};
  }

  fs::path folder_;
};

// The sum over all triangle corners, in glTF's metres and axes.
Vec3 corner_sum(const TriangleMesh& mesh) {
  RootFrame frame;
  frame.unit = mesh.unit;
  frame.up = mesh.up;
  const NodeMatrix m = matrix_of(frame);
  Vec3 sum = Vec3::Zero();
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t corner : triangle) {
      const Vec3& p = mesh.positions[corner];
      for (std::size_t row = 0; row < 3; ++row) {
        sum[static_cast<int>(row)] += m[row] * p[0] + m[4 + row] * p[1] + m[8 + row] * p[2];
      }
    }
  }
  return sum;
}

TEST_F(SecondReaders, TakeEveryFileWeWriteWithoutAWarning) {
  std::string files;
  for (const auto& entry : fs::directory_iterator(folder_)) {
    if (entry.path().extension() != ".bin") files += ' ' + quoted(entry.path());
  }
  const std::string text = output_of("node " + quoted(kNpm / "validate.mjs") + files);
  std::size_t seen = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const auto line = nlohmann::json::parse(text.substr(begin, end - begin), nullptr, false);
    begin = end + 1;
    ASSERT_TRUE(line.is_object()) << text;
    const std::string name = line["file"];
    SCOPED_TRACE(name);
    ++seen;
    ASSERT_FALSE(line.contains("failure")) << line["failure"];
    EXPECT_EQ(line["validator"]["errors"], 0) << line["validator"]["messages"];
    EXPECT_EQ(line["validator"]["warnings"], 0) << line["validator"]["messages"];

    // Their numbers against those of our reader, which knows the program's coordinates.
    const TriangleMesh mesh = read(folder_ / name);
    const auto& theirs = line["transform"];
    EXPECT_EQ(line["validator"]["triangles"], mesh.triangles.size());
    EXPECT_EQ(theirs["triangles"], mesh.triangles.size());
    const Vec3 sum = corner_sum(mesh);
    for (int k = 0; k < 3; ++k) {
      const double scale = 1e-9 * (1 + std::abs(sum[k]));
      EXPECT_NEAR(theirs["sums"][static_cast<std::size_t>(k)].get<double>(), sum[k], scale);
    }
    std::map<std::string, std::size_t> count;
    for (std::size_t t = 0; t < mesh.triangles.size() && !mesh.elements.empty(); ++t) {
      count[mesh.elements[mesh.triangle_element[t]].name] += 3;
    }
    for (const auto& primitive : theirs["primitives"]) {
      if (primitive["name"].is_null()) continue;
      EXPECT_EQ(primitive["count"], count[primitive["name"].get<std::string>()]);
      if (!primitive["element"].is_null()) {
        const std::size_t element = primitive["element"];
        ASSERT_LT(element, mesh.elements.size());
        EXPECT_EQ(mesh.elements[element].name, primitive["name"].get<std::string>());
      }
    }
    if (name.starts_with("lines")) {
      EXPECT_EQ(theirs["extras"]["report"]["triangles"], 320);
      EXPECT_EQ(theirs["lines"], 28);
    }
  }
  EXPECT_EQ(seen, 30u);
}

TEST_F(SecondReaders, WriteFilesThatWeReadRight) {
  const std::string command = "node " + quoted(kNpm / "variants.mjs") + ' ' +
                              quoted(folder_ / "plain.glb") + ' ' + quoted(folder_) +
                              " >/dev/null 2>&1";
  ASSERT_EQ(std::system(command.c_str()), 0);
  const TriangleMesh plain = read(folder_ / "plain.glb");
  // How far each way of packing may move a vertex, in millimetres of a part of 60.
  const std::map<std::string, double> ways{{"rewritten", 0},
                                           {"sparse", 0},
                                           {"meshopt", 0},
                                           {"quantized", 1e-3},
                                           {"meshopt_filtered", 4e-3},
                                           {"draco", 1e-3},
                                           {"draco_sequential", 1e-3}};
  for (const auto& [way, tolerance] : ways) {
    SCOPED_TRACE(way);
    const TriangleMesh mesh = read(folder_ / ("variant_" + way + ".glb"));
    EXPECT_EQ(mesh.triangles.size(), plain.triangles.size());
    EXPECT_EQ(mesh.positions.size(), plain.positions.size());
    EXPECT_EQ(mesh.unit, LengthUnit::kMillimetre);
    EXPECT_EQ(mesh.up, UpAxis::kZ);
    EXPECT_EQ(mesh.name, plain.name);
    ASSERT_EQ(mesh.elements.size(), plain.elements.size());
    for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
      EXPECT_EQ(mesh.elements[e].name, plain.elements[e].name);
      EXPECT_EQ(mesh.elements[e].solid, plain.elements[e].solid);
    }
    for (const Vec3& p : mesh.positions) {
      double nearest = 1e9;
      for (const Vec3& q : plain.positions) nearest = std::min(nearest, (p - q).norm());
      ASSERT_LE(nearest, tolerance);
    }
  }
}

}  // namespace
}  // namespace diesink
