// Text and binary STL read by several threads is the mesh, the warnings and the error that one
// thread makes of it.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "formats/registry.h"
#include "tests/support/die_mesh.h"
#include "tests/support/mesh_signature.h"
#include "tests/support/random_mesh.h"

namespace diesink {
namespace {

struct Sample {
  std::string name;
  const Format* format;
  std::string text;
};

// Everything a reading says and makes, in the order it makes it.
std::string told(const Sample& sample, int threads, std::size_t parallel_bytes,
                 std::size_t max_triangles) {
  ReadOptions options;
  options.file_name = sample.name;
  options.threads = threads;
  options.parallel_bytes = parallel_bytes;
  options.max_triangles = max_triangles;
  Diagnostics diagnostics;
  const Result<TriangleMesh> mesh =
      sample.format->read(std::as_bytes(std::span(sample.text)), options, diagnostics);
  if (!mesh) return to_text(mesh.error());
  std::string all;
  for (const Diagnostic& d : diagnostics.all()) all += to_text(d) + "\n";
  for (const std::string& line : testing::signature(*mesh, {})) all += line + "\n";
  // The order of vertices and triangles, which a signature leaves out.
  for (const Vec3& p : mesh->positions) all += std::to_string(p.x()) + " ";
  for (const auto& t : mesh->triangles) all += std::to_string(t[0] + t[1] + t[2]) + " ";
  return all;
}

std::vector<Sample> samples() {
  std::vector<Sample> all;
  const auto add = [&](const std::string& name, const Format& format, const TriangleMesh& mesh,
                       bool ascii = true) {
    WriteOptions options;
    options.ascii = ascii;
    options.lines = true;
    const Result<WrittenMesh> written = format.write(mesh, options);
    const std::vector<std::byte>& bytes = written->files[0].bytes;
    all.push_back(
        {name + "." + std::string(format.id),
         &format,
         {static_cast<const char*>(static_cast<const void*>(bytes.data())), bytes.size()}});
  };
  // More facets than a wave of the weld has.
  add("large", kStl, test::die_mesh(60, 6, 1), false);
  // Faces that count backwards, whose numbers hang on all that stands before them, and some that
  // name what comes after them.
  std::string backwards, forwards;
  for (int i = 0; i < 60; ++i) {
    const std::string n = std::to_string(i);
    backwards += "v " + n + " 0 0\nv 0 " + n + " 0\nv 0 0 " + n + ".5\nvt 0 0\nvn 0 0 1\n";
    backwards += i % 2 == 0 ? "f -3/-1/-1 -2/-1/-1 -1/-1/-1\n" : "f -1 -2 -3 -1\nl -1 -2\n";
    forwards += "v " + n + " 1 2\n";
    const std::string far = std::to_string(i % 7 == 3 ? 60 - i : 1 + i / 2);
    forwards += "f 1 " + far + (i % 5 == 0 ? " 2 3\n" : " 2\n");
  }
  all.push_back({"backwards.obj", &kObj, backwards});
  all.push_back({"forwards.obj", &kObj, forwards});
  TriangleMesh colored = test::die_mesh(8, 6, 1);
  colored.elements.back().color = {200, 100, 50, 255};
  add("colored", kStl, colored, false);
  for (const Format* format : {&kStl, &kObj, &kPly, &kOff}) {
    add("die", *format, test::die_mesh(8, 6, 1));
    for (unsigned seed = 0; seed < 6; ++seed) {
      add("random" + std::to_string(seed), *format, testing::random_mesh(seed, {}));
    }
    const std::string folder =
        std::string(DIESINK_SOURCE_DIR) + "/fixtures/meshes/" + std::string(format->id);
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      std::ifstream file(entry.path(), std::ios::binary);
      std::string text{std::istreambuf_iterator<char>(file), {}};
      if (text.size() > 20'000) continue;
      all.push_back({entry.path().filename().string(), format, std::move(text)});
    }
  }
  return all;
}

void expect_the_same(const Sample& sample, const std::string& what,
                     std::size_t max_triangles = 50'000'000) {
  const std::string one = told(sample, 1, std::size_t{1} << 30, max_triangles);
  for (const int threads : {2, 5}) {
    for (const std::size_t parallel_bytes : {16U, 700U}) {
      ASSERT_EQ(told(sample, threads, parallel_bytes, max_triangles), one)
          << sample.name << " " << what << " " << threads << " threads, parts of "
          << parallel_bytes / 4;
    }
  }
}

TEST(MeshThreads, GoodTextIsTheSameForAnyNumberOfThem) {
  for (const Sample& sample : samples()) expect_the_same(sample, "as it is");
}

TEST(MeshThreads, OtherLineEndsAndComments) {
  for (const Sample& sample : samples()) {
    // A binary file's data are no lines.
    if (sample.text.find('\0') != std::string::npos) continue;
    for (const std::string end : {"\r\n", "\r", "\n\n \t\n"}) {
      Sample other = sample;
      other.text.clear();
      for (const char c : sample.text) {
        if (c == '\n') {
          other.text += end;
        } else {
          other.text += c;
        }
      }
      expect_the_same(other, "with other line ends");
    }
    Sample commented = sample;
    for (std::size_t at = commented.text.size(); at-- > 0;) {
      if (commented.text[at] == '\n' && at % 3 == 0) commented.text.insert(at, " # up: y");
    }
    expect_the_same(commented, "with comments");
  }
}

TEST(MeshThreads, LimitsAreMetAtTheSamePlace) {
  for (const Sample& sample : samples()) {
    for (const std::size_t most : {1U, 7U, 20U}) expect_the_same(sample, "limited", most);
  }
}

TEST(MeshThreads, WhatIsWrongIsToldAlike) {
  std::mt19937 random(7);
  const std::vector<std::string> words{"x",     "-1",         "\n",   " ",   "nan",
                                       "1e999", "facet",      "#",    "9 9", "3",
                                       "2e9",   "endfacet\n", "\\\n", "0,5", "\r"};
  for (const Sample& sample : samples()) {
    for (int round = 0; round < 40; ++round) {
      Sample spoiled = sample;
      for (int change = 0; change <= round % 3; ++change) {
        const std::size_t at = random() % (spoiled.text.size() + 1);
        const std::size_t cut = std::min<std::size_t>(random() % 4, spoiled.text.size() - at);
        spoiled.text.replace(at, cut, words[random() % words.size()]);
      }
      if (round % 10 == 0) spoiled.text.resize(spoiled.text.size() * (round + 5) / 50);
      expect_the_same(spoiled, "round " + std::to_string(round));
      if (HasFatalFailure()) return;
    }
  }
}

}  // namespace
}  // namespace diesink
