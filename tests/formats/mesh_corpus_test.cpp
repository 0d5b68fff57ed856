// Meshes made by other programs, good and bad, where a checkout has the corpus beside it.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iostream>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "formats/mesh_file.h"

namespace diesink {
namespace {

struct Entry {
  std::string file, exercises, triangles;
};

std::string corpus() { return std::string(DIESINK_SOURCE_DIR) + "/../shared/corpus"; }

// The entries of MANIFEST.tsv in the formats read here, from folders that begin with `kind`.
std::vector<Entry> entries(const std::string& kind) {
  std::vector<Entry> found;
  std::ifstream manifest(corpus() + "/MANIFEST.tsv");
  for (std::string line; std::getline(manifest, line);) {
    std::istringstream cells(line);
    Entry entry;
    std::string source, licence;
    std::getline(cells, entry.file, '\t');
    std::getline(cells, source, '\t');
    std::getline(cells, licence, '\t');
    std::getline(cells, entry.exercises, '\t');
    std::getline(cells, entry.triangles, '\t');
    if (!entry.file.starts_with(kind)) continue;
    for (const char* format : {"/stl/", "/obj/", "/ply/", "/off/"}) {
      if (entry.file.find(format) != std::string::npos) found.push_back(entry);
    }
  }
  return found;
}

struct Outcome {
  std::optional<MeshFile> file;
  std::string said;
};

Outcome read(const std::string& file) {
  Diagnostics diagnostics;
  Result<MeshFile> mesh = read_mesh_file(corpus() + "/" + file, {}, diagnostics);
  Outcome outcome;
  if (mesh) outcome.file = std::move(*mesh);
  if (!mesh) outcome.said = to_text(mesh.error());
  for (const Diagnostic& d : diagnostics.all()) outcome.said += to_text(d) + "\n";
  return outcome;
}

class MeshCorpus : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(corpus() + "/MANIFEST.tsv")) {
      std::cout << "skipped: no corpus at " << corpus() << '\n';
      GTEST_SKIP();
    }
  }
};

TEST_F(MeshCorpus, GoodOnesAreReadWithTheirTriangles) {
  // What the manifest counts by another rule: UTF-16 may be refused with a clear message; the
  // manifest's zero for HalfDonut is another reader's, its header counts 288.
  const std::string utf16 = "good/obj/assimp__box_UTF16BE.obj",
                    donut = "good/stl/numpystl__HalfDonut_binary.stl";
  std::size_t count = 0;
  for (const Entry& entry : entries("good/")) {
    ++count;
    const Outcome outcome = read(entry.file);
    if (entry.file == utf16) {
      EXPECT_FALSE(outcome.file);
      EXPECT_NE(outcome.said.find("UTF-16"), std::string::npos) << outcome.said;
      continue;
    }
    ASSERT_TRUE(outcome.file) << outcome.said;
    const std::string triangles = std::to_string(outcome.file->mesh.triangles.size());
    if (entry.file == donut) {
      EXPECT_EQ(triangles, "288");
    } else if (entry.triangles != "?") {
      EXPECT_EQ(triangles, entry.triangles) << entry.file << " " << outcome.said;
    }
  }
  EXPECT_GT(count, 60U);
}

TEST_F(MeshCorpus, BadOnesAreRefusedOrTold) {
  // Legal, or odd in a way that is none of a reader's business.
  const std::vector<std::string> fine{
      "_VALID",               // so the corpus says
      "denormal.stl",         // a small triangle is a triangle
      "vertical_wall_only",   // no base surface, but a mesh
      "trimesh__soup",        // no two facets meet
      "trimesh__busted",      // open, which `info` tells
      "draco__eof_test",      // no line end at the end
      "isolated_triangles",   // several shells
      "non_manifold_wrap",    // which `info` tells
      "issue-161",            // corners with and without texture coordinates
      "issue-330",            // a regression of another reader
      "no_face_in_chunk",     // a group without faces
      "libigl__degenerated",  // slivers, no two corners alike
      "extra_vertex",         // a vertex nobody uses
  };
  std::size_t count = 0;
  for (const Entry& entry : entries("bad/")) {
    ++count;
    const Outcome outcome = read(entry.file);
    bool accepted = false;
    for (const std::string& name : fine)
      accepted = accepted || entry.file.find(name) != std::string::npos;
    if (entry.file.find("_VALID") != std::string::npos) {
      EXPECT_TRUE(outcome.file) << entry.file << outcome.said;
    }
    if (!accepted) {
      EXPECT_NE(outcome.said, "") << entry.file << ": " << entry.exercises;
    }
    if (!outcome.file) {
      EXPECT_NE(outcome.said.find(": error: "), std::string::npos) << outcome.said;
    }
  }
  EXPECT_GT(count, 80U);
}

}  // namespace
}  // namespace diesink
