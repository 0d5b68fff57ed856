// For each pair of formats and every fixture: what both can hold comes back bit for bit. What each
// holds is the registry's own word.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "formats/mesh_file.h"
#include "tests/formats/round_trip.h"

namespace diesink {
namespace {

using testing::both;
using testing::Compared;
using testing::difference;
using testing::RoundTripKind;
using testing::signature;
using testing::through;

// From the remarks: STL has names and full precision in ASCII, units and colours in binary only,
// OBJ no alpha of vertices. STL has no place for the solid of an element.
Compared keeps_of(const Format& format, bool ascii) {
  const bool stl = format.id == "stl";
  const auto kept = [](Keeps what) { return what != Keeps::kNo; };
  Compared keeps;
  keeps.names = kept(format.names) && (!stl || ascii);
  keeps.solids = keeps.names && !stl;
  keeps.colors = kept(format.colors) && !(stl && ascii);
  keeps.five_bits = stl;
  keeps.opaque = format.id == "obj";
  keeps.vertex_colors = keeps.colors && kept(format.sharing);
  keeps.normals = kept(format.normals);
  keeps.normals_as_float = format.normals == Keeps::kFloat32;
  keeps.curves = kept(format.lines);
  keeps.marks = kept(format.units) && !(stl && ascii);
  keeps.as_float = format.positions == Keeps::kFloat32 && !(stl && ascii);
  return keeps;
}

std::vector<RoundTripKind> all_kinds() {
  std::vector<RoundTripKind> kinds;
  for (const Format* format : all_formats()) {
    if (format->read == nullptr || format->write == nullptr) continue;
    kinds.push_back({format->id.data(), format, false, keeps_of(*format, false)});
    if (format != &kStl && format != &kPly) continue;
    kinds.push_back(
        {format == &kStl ? "stl ascii" : "ply ascii", format, true, keeps_of(*format, true)});
  }
  return kinds;
}

struct Fixture {
  std::string name;
  TriangleMesh mesh;
};

// What of the folder's files can be read, up to `max_bytes` each.
std::vector<Fixture> fixtures_in(const std::string& folder, std::uintmax_t max_bytes) {
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file() && entry.file_size() <= max_bytes) paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  std::vector<Fixture> fixtures;
  for (const std::filesystem::path& path : paths) {
    if (format_of_ending(path.string()) == nullptr) continue;
    Diagnostics diagnostics;
    Result<MeshFile> file = read_mesh_file(path.string(), {}, diagnostics);
    // Of all formats glTF alone is read beyond the limit of coordinates, with a warning.
    const auto within = [](const Vec3& p) { return p.cwiseAbs().maxCoeff() <= 1e9; };
    if (file && !file->mesh.triangles.empty() &&
        std::all_of(file->mesh.positions.begin(), file->mesh.positions.end(), within)) {
      fixtures.push_back({path.string().substr(folder.size()), std::move(file->mesh)});
    }
  }
  return fixtures;
}

TriangleMesh in_floats(TriangleMesh mesh) {
  for (Vec3& p : mesh.positions) p = p.cast<float>().cast<double>();
  return mesh;
}

void expect_pairs(const Fixture& fixture, const testing::RoundTripFolder& folder) {
  const std::vector<RoundTripKind> kinds = all_kinds();
  const TriangleMesh floats = in_floats(fixture.mesh);
  for (const RoundTripKind& first : kinds) {
    const TriangleMesh from_double = through(fixture.mesh, first, folder, true);
    const TriangleMesh from_float = through(floats, first, folder, true);
    for (const RoundTripKind& second : kinds) {
      const Compared kept = both(first.keeps, second.keeps);
      const TriangleMesh& given = kept.as_float ? floats : fixture.mesh;
      const TriangleMesh back =
          through(kept.as_float ? from_float : from_double, second, folder, true);
      EXPECT_EQ(difference(signature(back, kept), signature(given, kept)), "")
          << fixture.name << ": " << first.name << ", then " << second.name;
      if (::testing::Test::HasFailure()) return;
      if (first.keeps.normals_as_float || second.keeps.normals_as_float) continue;
      if (first.format->sharing == Keeps::kYes && second.format->sharing == Keeps::kYes) {
        EXPECT_EQ(back.positions, given.positions)
            << fixture.name << ": " << first.name << ", then " << second.name;
      }
    }
  }
}

TEST(MeshPairs, EveryFixtureThroughEveryPair) {
  const testing::RoundTripFolder folder;
  const std::vector<Fixture> fixtures =
      fixtures_in(std::string(DIESINK_SOURCE_DIR) + "/fixtures/meshes", 1U << 20);
  EXPECT_GT(fixtures.size(), 20U);
  for (const Fixture& fixture : fixtures) expect_pairs(fixture, folder);
}

TEST(MeshPairs, FilesOfOthersThroughEveryPair) {
  const std::string corpus = std::string(DIESINK_SOURCE_DIR) + "/../shared/corpus/good";
  if (!std::filesystem::exists(corpus)) {
    std::cout << "skipped: no corpus at " << corpus << '\n';
    GTEST_SKIP();
  }
  const testing::RoundTripFolder folder;
  for (const Fixture& fixture : fixtures_in(corpus, 8'000)) expect_pairs(fixture, folder);
}

}  // namespace
}  // namespace diesink
