// What a format can hold comes back to the bit: STL, OBJ, PLY and OFF, each alone and each after
// another.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <algorithm>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/parallel.h"
#include "formats/mesh_file.h"
#include "formats/registry.h"
#include "tests/formats/round_trip.h"
#include "tests/support/die_mesh.h"
#include "tests/support/mesh_signature.h"
#include "tests/support/random_mesh.h"

namespace diesink {
namespace {

using testing::both;
using testing::Compared;
using testing::through;
using Kind = testing::RoundTripKind;
using testing::difference;
using testing::MeshTraits;
using testing::random_mesh;
using testing::signature;

const std::vector<Kind>& kinds() {
  static const std::vector<Kind> all{
      {"stl", &kStl, false, {false, false, false, false, false, false, true, true}},
      {"stl_ascii", &kStl, true, {true, false, false, false, false, false, false, false}},
      {"obj", &kObj, false, {true, true, true, true, true, true, true, false}},
      {"ply", &kPly, false, {true, true, true, true, true, true, true, false}},
      {"ply_ascii", &kPly, true, {true, true, true, true, true, true, true, false}},
      {"off", &kOff, false, {false, false, true, false, true, false, true, false}},
  };
  return all;
}

// glTF keeps as floats what others keep as doubles, and normals of its own rounding.
const std::vector<Kind>& gltf_kinds() {
  static const std::vector<Kind> all{
      {"gltf", &kGltf, false, {true, true, true, false, true, true, true, true}},
      {"glb", &kGlb, false, {true, true, true, false, true, true, true, true}},
  };
  return all;
}

// OBJ and ASCII PLY cannot tell a colour apart that is not there from one an element without a name
// has, and so on: the random meshes keep within what every format can say.
MeshTraits traits_of(const Kind& kind) {
  MeshTraits traits;
  traits.float_positions = kind.keeps.as_float;
  return traits;
}

TEST(MeshRoundTrip, EveryFormatAlone) {
  const testing::RoundTripFolder folder;
  for (const Kind& kind : kinds()) {
    for (unsigned seed = 0; seed < 150; ++seed) {
      const TriangleMesh mesh = random_mesh(seed, traits_of(kind));
      const TriangleMesh back = through(mesh, kind, folder);
      ASSERT_EQ(difference(signature(back, kind.keeps), signature(mesh, kind.keeps)), "")
          << kind.name << " " << seed;
      if (kind.format->sharing == Keeps::kYes) {
        EXPECT_EQ(back.positions, mesh.positions) << kind.name << " " << seed;
      }
    }
  }
}

TEST(MeshRoundTrip, EveryFormatAfterEveryOther) {
  const testing::RoundTripFolder folder;
  for (const Kind& first : kinds()) {
    for (const Kind& second : kinds()) {
      const Compared kept = both(first.keeps, second.keeps);
      for (unsigned seed = 0; seed < 12; ++seed) {
        const TriangleMesh mesh = random_mesh(seed, {});
        const TriangleMesh back =
            through(through(through(mesh, first, folder), second, folder), first, folder);
        ASSERT_EQ(difference(signature(back, kept), signature(mesh, kept)), "")
            << first.name << " " << second.name << " " << seed;
      }
    }
  }
}

TEST(MeshRoundTrip, GltfAndEveryOtherAfterEachOther) {
  const testing::RoundTripFolder folder;
  for (const Kind& gltf : gltf_kinds()) {
    std::vector<Kind> others = kinds();
    others.insert(others.end(), gltf_kinds().begin(), gltf_kinds().end());
    for (const Kind& other : others) {
      const Compared kept = both(gltf.keeps, other.keeps);
      for (unsigned seed = 0; seed < 12; ++seed) {
        MeshTraits traits;
        traits.float_positions = true;
        const TriangleMesh mesh = random_mesh(seed, traits);
        const TriangleMesh there = through(through(mesh, gltf, folder), other, folder);
        ASSERT_EQ(difference(signature(there, kept), signature(mesh, kept)), "")
            << gltf.name << " " << other.name << " " << seed;
        const TriangleMesh back = through(there, gltf, folder);
        ASSERT_EQ(difference(signature(back, kept), signature(mesh, kept)), "")
            << gltf.name << " " << other.name << " and back " << seed;
      }
    }
  }
}

TEST(MeshRoundTrip, ADie) {
  const testing::RoundTripFolder folder;
  const TriangleMesh die = test::die_mesh();
  for (const Kind& kind : kinds()) {
    const TriangleMesh back = through(die, kind, folder);
    EXPECT_EQ(difference(signature(back, kind.keeps), signature(die, kind.keeps)), "") << kind.name;
    if (kind.format->sharing == Keeps::kYes) {
      EXPECT_EQ(back.positions.size(), die.positions.size());
    }
  }
}

// Each full buffer of a megabyte, each element with Draco, tells the share that is written.
TEST(MeshRoundTrip, WritersTellHowFarTheyAre) {
  const TriangleMesh mesh = test::die_mesh(220, 60, 7);
  struct Case {
    const Format* format;
    bool ascii = false, draco = false;
  };
  for (const Case& each : {Case{&kStl}, Case{&kStl, true}, Case{&kObj}, Case{&kPly},
                           Case{&kPly, true}, Case{&kOff}, Case{&kGlb}, Case{&kGlb, false, true}}) {
    WriteOptions options;
    options.ascii = each.ascii;
    options.draco = each.draco;
    options.lines = true;
    std::vector<double> told;
    const std::function<void(double)> tell = [&](double part) { told.push_back(part); };
    {
      const ProgressSpan span(tell, 0, 1);
      ASSERT_TRUE(each.format->write(mesh, options));
    }
    const std::string what =
        std::string(each.format->id) + (each.ascii ? " ascii" : "") + (each.draco ? " draco" : "");
    ASSERT_GE(told.size(), 2U) << what;
    EXPECT_TRUE(std::is_sorted(told.begin(), told.end())) << what;
    EXPECT_GT(told.front(), 0) << what;
    EXPECT_LT(told.front(), 0.7) << what;
    EXPECT_NEAR(told.back(), 1, 1e-12) << what;
  }
}

TEST(MeshRoundTrip, WritingWhatWasReadGivesTheSameBytes) {
  for (const Kind& kind : kinds()) {
    if (kind.format == &kOff) continue;  // numbers its colours anew
    for (unsigned seed = 0; seed < 40; ++seed) {
      WriteOptions options;
      options.program_comment = "diesink test";
      options.ascii = kind.ascii;
      options.lines = true;
      MeshTraits traits = traits_of(kind);
      traits.colors = kind.format != &kObj;  // its colours are in the library, not read from memory
      const Result<WrittenMesh> first = kind.format->write(random_mesh(seed, traits), options);
      ASSERT_TRUE(first);
      Diagnostics diagnostics;
      const Result<TriangleMesh> back = kind.format->read(first->files[0].bytes, {}, diagnostics);
      ASSERT_TRUE(back) << to_text(back.error());
      const Result<WrittenMesh> second = kind.format->write(*back, options);
      ASSERT_TRUE(second);
      // A binary STL's colours lose bits once.
      if (kind.format == &kStl && !kind.ascii) {
        const Result<TriangleMesh> again =
            kind.format->read(second->files[0].bytes, {}, diagnostics);
        ASSERT_TRUE(again);
        const Result<WrittenMesh> third = kind.format->write(*again, options);
        ASSERT_TRUE(third);
        EXPECT_EQ(third->files[0].bytes, second->files[0].bytes) << seed;
      } else {
        EXPECT_EQ(second->files[0].bytes, first->files[0].bytes) << kind.name << " " << seed;
      }
    }
  }
}

// In OBJ a backslash at the end of a line joins the next one to it.
TEST(MeshRoundTrip, NamesThatEndInABackslashTakeNoLineWithThem) {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  for (const std::string name : {"\\", "a\\", "\\b", "c\\ \\", "end"}) {
    mesh.triangle_element.push_back(static_cast<std::uint32_t>(mesh.elements.size()));
    mesh.elements.push_back({name, name, {}});
    mesh.triangles.push_back({0, 1, 2});
  }
  mesh.name = "die\\";
  for (const Format* format : {&kStl, &kObj, &kPly, &kGlb}) {
    WriteOptions options;
    options.ascii = true;
    options.file_stem = "part";
    const Result<WrittenMesh> written = format->write(mesh, options);
    ASSERT_TRUE(written) << format->id;
    for (const FileBytes& file : written->files) {
      const std::string_view text{
          static_cast<const char*>(static_cast<const void*>(file.bytes.data())), file.bytes.size()};
      if (format == &kObj) {
        EXPECT_EQ(text.find("\\\n"), text.npos) << text;
      }
    }
    Diagnostics diagnostics;
    const Result<TriangleMesh> read =
        format->read(written->files[0].bytes, ReadOptions{}, diagnostics);
    ASSERT_TRUE(read) << format->id << " " << to_text(read.error());
    ASSERT_EQ(read->triangles.size(), mesh.triangles.size()) << format->id;
    ASSERT_EQ(read->elements.size(), mesh.elements.size()) << format->id;
    for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
      EXPECT_EQ(read->elements[e].name, mesh.elements[e].name) << format->id;
      if (format != &kStl) {
        EXPECT_EQ(read->elements[e].solid, mesh.elements[e].solid) << format->id;
      }
    }
    if (format != &kStl) {
      EXPECT_EQ(read->name, mesh.name) << format->id;
    }
  }
}

TEST(MeshRoundTrip, FifteenBitColorsComeBackAsNearAsTheyCan) {
  TriangleMesh mesh = testing::box_mesh(Vec3(0, 0, 0), Vec3(1, 1, 1));
  mesh.elements = {{"a", "", {{{200, 100, 3, 255}}}}, {"b", "", std::nullopt}};
  mesh.triangle_element.assign(12, 0);
  mesh.triangle_element[7] = 1;
  const Result<WrittenMesh> written = kStl.write(mesh, {});
  ASSERT_TRUE(written);
  Diagnostics diagnostics;
  const Result<TriangleMesh> back = kStl.read(written->files[0].bytes, {}, diagnostics);
  ASSERT_TRUE(back);
  ASSERT_EQ(back->elements.size(), 2U);
  ASSERT_TRUE(back->elements[0].color);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR((*back->elements[0].color)[i], (*mesh.elements[0].color)[i], 4);
  }
  EXPECT_FALSE(back->elements[1].color);
  EXPECT_EQ(back->triangle_element, mesh.triangle_element);
}

TEST(MeshRoundTrip, BinaryStlTellsHowFarFloatsMovedTheVertices) {
  TriangleMesh mesh = testing::box_mesh(Vec3(1e6, 0, 0), Vec3(1e6 + 0.03, 1, 1));
  const Result<WrittenMesh> written = kStl.write(mesh, {});
  ASSERT_TRUE(written);
  const double moved = std::abs(static_cast<double>(static_cast<float>(1e6 + 0.03)) - (1e6 + 0.03));
  EXPECT_DOUBLE_EQ(written->deviation, moved);
  mesh.positions[0].x() = 1e39;
  EXPECT_FALSE(kStl.write(mesh, {}));
}

TEST(MeshRoundTrip, ALargeAsciiStlIsTheSameForAnyNumberOfThreads) {
  TriangleMesh torus = testing::torus_mesh(220, 250);
  for (std::uint32_t e = 0; e < 40; ++e)
    torus.elements.push_back({"S" + std::to_string(e) + " endfacet", "", std::nullopt});
  for (std::size_t t = 0; t < torus.triangles.size(); ++t) {
    torus.triangle_element.push_back(static_cast<std::uint32_t>(t * 40 / torus.triangles.size()));
  }
  WriteOptions options;
  options.ascii = true;
  const Result<WrittenMesh> written = kStl.write(torus, options);
  ASSERT_TRUE(written);
  ASSERT_GT(written->files[0].bytes.size(), std::size_t{16} << 20);
  const Compared kept{true, true, false, false, false, false, false, false};
  for (const int threads : {1, 2, 7}) {
    ReadOptions reading;
    reading.threads = threads;
    Diagnostics diagnostics;
    const Result<TriangleMesh> mesh = kStl.read(written->files[0].bytes, reading, diagnostics);
    ASSERT_TRUE(mesh) << to_text(mesh.error());
    EXPECT_TRUE(diagnostics.all().empty());
    EXPECT_EQ(mesh->positions.size(), torus.positions.size());
    EXPECT_EQ(mesh->triangle_element, torus.triangle_element);
    EXPECT_EQ(difference(signature(*mesh, kept), signature(torus, kept)), "") << threads;
  }
}

TEST(MeshRoundTrip, ALargeObjIsTheSameForAnyNumberOfThreads) {
  // Groups, normals, comments, polygons, backward numbers and continued lines over the sections'
  // borders.
  const TriangleMesh torus = testing::torus_mesh(400, 500);
  std::string text = "# units: mm\n";
  char line[200];
  for (std::size_t i = 0; i < torus.positions.size(); ++i) {
    const Vec3& p = torus.positions[i];
    std::snprintf(
        line, sizeof line,
        i % 5 == 0 ? "v %.17g \\\r\n %.17g %.17g\r\nvn 0 0 1\n" : "v %.17g %.17g %.17g\nvn 0 1 0\n",
        p.x(), p.y(), p.z());
    text += line;
    if (i < 4) continue;
    if (i % 1000 == 0) text += "g part" + std::to_string(i / 1000 % 7) + "\n";
    text += i % 3 == 0 ? "f -1//-1 -2//-2 -3//-3 -4//-4\n" : "f -1 -3 -4\n";
  }
  ASSERT_GT(text.size(), std::size_t{16} << 20);
  std::vector<std::string> expected;
  std::size_t triangles = 0;
  for (const int threads : {1, 2, 7}) {
    ReadOptions options;
    options.threads = threads;
    Diagnostics diagnostics;
    const Result<TriangleMesh> mesh =
        kObj.read(std::as_bytes(std::span(text)), options, diagnostics);
    ASSERT_TRUE(mesh) << to_text(mesh.error());
    EXPECT_EQ(mesh->positions, torus.positions);
    EXPECT_EQ(mesh->elements.size(), 8U);
    std::vector<std::string> lines = signature(*mesh, {});
    for (const Diagnostic& d : diagnostics.all()) lines.push_back(to_text(d));
    if (expected.empty()) {
      expected = std::move(lines);
      triangles = mesh->triangles.size();
    } else {
      EXPECT_EQ(mesh->triangles.size(), triangles);
      EXPECT_TRUE(lines == expected) << threads;
    }
  }
}

}  // namespace
// Normals numbered as the vertices are take a shorter way to the file than others.
TEST(MeshRoundTrip, HowNormalsAreNumberedDoesNotMatter) {
  for (const bool with_loose_vertex : {false, true}) {
    TriangleMesh mesh;
    mesh.positions = {{0, 0, 0}, {2, 0, -0.0}, {2, 1, 0.5}, {0, 1, 0.5}};
    mesh.normals = {{0, 0, 1}, {0, 0.6, 0.8}, {0.6, -0.0, 0.8}, {1, 0, 0}};
    if (with_loose_vertex) {
      mesh.positions.emplace_back(7, 7, 7);
      mesh.normals.emplace_back(0, 1, 0);
    }
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    mesh.corner_normals = mesh.triangles;
    TriangleMesh reversed = mesh;
    std::reverse(reversed.normals.begin(), reversed.normals.end());
    for (auto& corners : reversed.corner_normals) {
      for (std::uint32_t& n : corners) n = static_cast<std::uint32_t>(mesh.normals.size()) - 1 - n;
    }
    for (const Format* const format : {&kPly, &kGlb}) {
      const auto as_numbered = format->write(mesh, {}), other = format->write(reversed, {});
      ASSERT_TRUE(as_numbered && other);
      if (format == &kGlb && with_loose_vertex) continue;  // its vertices are those of triangles
      EXPECT_EQ(as_numbered->files[0].bytes, other->files[0].bytes) << format->id;
    }
  }
}

}  // namespace diesink
