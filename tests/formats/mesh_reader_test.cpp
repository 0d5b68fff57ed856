// What the readers make of odd, broken, cut and spoiled files.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "formats/registry.h"
#include "tests/support/die_mesh.h"
#include "tests/support/random_mesh.h"

namespace diesink {
namespace {

std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text));
}

struct Outcome {
  bool read = false;
  TriangleMesh mesh;
  std::string said;  // the error, or the warnings, a line each
};

Outcome read(const Format& format, const std::string& content, ReadOptions options = {}) {
  options.file_name = "f";
  Diagnostics diagnostics;
  Result<TriangleMesh> mesh = format.read(bytes_of(content), options, diagnostics);
  Outcome outcome;
  outcome.read = mesh.has_value();
  if (mesh) {
    outcome.mesh = std::move(*mesh);
    for (const Diagnostic& d : diagnostics.all()) outcome.said += to_text(d) + "\n";
  } else {
    outcome.said = to_text(mesh.error());
  }
  return outcome;
}

// Whatever comes out of a reader must hold together.
void expect_sound(const TriangleMesh& mesh, const std::string& what) {
  for (const std::array<std::uint32_t, 3>& t : mesh.triangles) {
    for (const std::uint32_t v : t) ASSERT_LT(v, mesh.positions.size()) << what;
  }
  for (const Vec3& p : mesh.positions) ASSERT_TRUE(p.cwiseAbs().maxCoeff() <= 1e9) << what;
  ASSERT_TRUE(mesh.triangle_element.empty() ||
              mesh.triangle_element.size() == mesh.triangles.size())
      << what;
  for (const std::uint32_t e : mesh.triangle_element) ASSERT_LT(e, mesh.elements.size()) << what;
  ASSERT_TRUE(mesh.corner_normals.empty() || mesh.corner_normals.size() == mesh.triangles.size())
      << what;
  for (const std::array<std::uint32_t, 3>& t : mesh.corner_normals) {
    for (const std::uint32_t n : t) ASSERT_LT(n, mesh.normals.size()) << what;
  }
  for (const Vec3& n : mesh.normals) ASSERT_NEAR(n.norm(), 1, 2e-3) << what;
  ASSERT_TRUE(mesh.vertex_colors.empty() || mesh.vertex_colors.size() == mesh.positions.size())
      << what;
  for (const MeshCurve& curve : mesh.curves) {
    for (const std::uint32_t v : curve.vertices) ASSERT_LT(v, mesh.positions.size()) << what;
  }
}

struct Broken {
  const Format* format;
  const char* content;
  const char* message;  // what the error begins with
};

constexpr const char* kFacet =
    " facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n   vertex 0 1 0\n"
    "  endloop\n endfacet\n";

TEST(MeshReader, SaysWhatIsWrongAndWhere) {
  const std::string stl = std::string("solid a\n") + kFacet;
  const std::string comma = "solid a\n facet normal 0 0 1\n outer loop\n vertex 0,5 0 0\n";
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
      "property float z\n";
  const std::vector<Broken> all{
      {&kStl, comma.c_str(), "f:4:9: error: \"0,5\" is not a number (decimals need a point)"},
      {&kStl, "solid a\n facet normal 0 0 1\n outer loop\n vertex 0 nan 0\n",
       "f:4:11: error: \"nan\" is no finite"},
      {&kStl, "solid a\n facet normal 0 0 1\n outer loop\n vertex 0 1e999 0\n",
       "f:4:11: error: \"1e999\" is larger"},
      {&kStl, "solid a\n facet normal 0 0 1\n outer loop\n vertex 0 2e9 0\n",
       "f:4:14: error: coordinate 2e+09 is beyond the limit of 1e+09"},
      {&kStl, "solid a\r\n facet normal 0 0 1\r\n inner loop\r\n",
       "f:3:2: error: found \"inner\", expected 'outer'"},
      {&kStl, "solid a\n facet normal 0 0 1\n outer loop\n vertex 0 0",
       "f:4:12: error: the file ends, expected"},
      {&kStl, "solid a\nendsolid a\nrubbish", "f:3:1: error: found \"rubbish\", expected 'solid'"},
      {&kStl, "solid", nullptr},
      {&kObj, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "f:4:1: error: vertex 4, but the file has 3"},
      {&kObj, "v 0 0 0\nf 1 0 1\n", "f:2:5: error: found \"0\", but numbers begin at 1"},
      {&kObj, "v 0 0 0\nf 1 1 -2\n", "f:2:7: error: \"-2\" counts back past the first"},
      {&kObj, "v 0 0 0\nf 1 1 1.5\n", "f:2:7: error: found \"1.5\", expected a vertex as"},
      {&kObj, "v 0 0\n", "f:1:1: error: the vertex has 2 numbers, expected at least 3"},
      {&kObj, "# only\n", "f: error: the file has no vertices"},
      {&kObj, "v 0 0 0\nl 1 2\n", "f:2:1: error: vertex 2, but the file has 1"},
      {&kObj, "\xFF\xFEv\0", "f: error: UTF-16 text is not read"},
      {&kOff, "OFF\n3 1\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n",
       "f:6:7: error: found \"3\", expected the number of a vertex"},
      {&kOff, "OFF\n-3 1 0\n", "f:2:1: error: found \"-3\", expected the number of vertices"},
      {&kOff, "OFF\n4000000000 1 0\n",
       "f:2:1: error: 4000000000 vertices do not fit in the 5 bytes left"},
      {&kOff, "OFF BINARY\n", "f:1:5: error: binary OFF is not read"},
      {&kOff, "4OFF\n1 0 0\n0 0 0 0\n", "f:1:1: error: \"4OFF\" has more than three dimensions"},
      {&kPly, "ply\nformat ascii 2.0\n", "f:2:8: error: found version \"2.0\", expected 1.0"},
      {&kPly, "ply\nformat ascii 1.0\nelement vertex -1\n",
       "f:3:9: error: found \"-1\" as the number of \"vertex\""},
      {&kPly, "ply\nformat ascii 1.0\nelement vertex 1\nproperty quad x\n",
       "f:4:10: error: unknown type \"quad\""},
      {&kPly, "ply\nformat ascii 1.0\nelement face 1\nproperty list uint64 int vertex_indices\n",
       "f:4:10: error: unknown type \"uint64\" of a list's length"},
      {&kPly, "ply\nformat ascii 1.0\nelement face 1\nproperty list float int vertex_indices\n",
       "f:4:10: error: found \"float\", expected a whole-number type"},
      {&kPly,
       "ply\nformat ascii 1.0\nelement vertex 1\nproperty int x\nproperty int y\nproperty int z\n"
       "element face 1\nproperty int material\nend_header\n0 0 0\n7\n",
       "f:7:9: error: the faces have no list property 'vertex_indices'"},
      {&kPly, "ply\nformat ascii 1.0\nend_header\n",
       "f:4:1: error: the file has no element 'vertex'"},
      {&kPly, "ply\nend_header\n", "f:2:1: error: the header has no 'format' line"},
  };
  for (const Broken& broken : all) {
    const std::string content =
        broken.message != nullptr && std::string(broken.message).find("UTF-16") != std::string::npos
            ? std::string("\xFF\xFEv\0", 4)
            : std::string(broken.content);
    const Outcome outcome = read(*broken.format, content);
    if (broken.message == nullptr) {
      EXPECT_TRUE(outcome.read) << content;
      continue;
    }
    EXPECT_FALSE(outcome.read) << content;
    EXPECT_TRUE(outcome.said.starts_with(broken.message))
        << outcome.said << "\nexpected " << broken.message;
  }
  const Outcome cut = read(kPly, ply + "end_header\n0 0\n");
  EXPECT_FALSE(cut.read);
  EXPECT_NE(cut.said.find("do not fit"), std::string::npos) << cut.said;
}

TEST(MeshReader, TakesWhatIsOddAndSaysSo) {
  const std::string cube_end = "endsolid\n";
  struct Odd {
    const Format* format;
    std::string content;
    std::size_t triangles;
    const char* warning;  // empty: none at all
  };
  const std::string facet = kFacet;
  std::string upper = "SOLID A B\n" + facet + "ENDSOLID\n";
  for (char& c : upper) c = static_cast<char>(std::toupper(c));
  std::string old_mac = "solid a\n" + facet + "endsolid\n";
  for (char& c : old_mac) c = c == '\n' ? '\r' : c;
  std::string against = facet;
  against.replace(against.find("0 0 1"), 5, "0 0 -1");
  std::string nan = facet;
  nan.replace(nan.find("0 0 1"), 5, "-nan(ind) 0 1");
  const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
  const std::vector<Odd> all{
      {&kStl, upper, 1, ""},
      {&kStl, old_mac, 1, ""},
      {&kStl, "\xEF\xBB\xBFsolid\n" + facet + cube_end, 1, ""},
      {&kStl, "solid a\n" + facet + facet, 2, "has no 'endsolid'"},
      {&kStl, "solid a\n" + facet + "solid b\n" + facet + "endsolid\n", 2, "has no 'endsolid'"},
      {&kStl, "solid a\nendsolid a\nsolid b\n" + facet + "end solid b\n", 1,
       "1 solid without facets"},
      {&kStl, "solid a\n" + against + cube_end, 1, "1 facet has a normal against the turn"},
      {&kStl, "solid a\n" + nan + cube_end, 1, "1 facet has a normal that is not finite"},
      {&kStl, std::string(84, '\0'), 0, "f:@80: warning: the file has no facets"},
      {&kObj, square + "f 1 2 3 4", 2, ""},
      {&kObj, square + "f -4 -3 -2 -1\n", 2, ""},
      {&kObj, square + "f 1 2 \\\n 3 \\\r\n 4\n", 2, ""},
      {&kObj, square + "f\t1/1/1\t2//\t3/5\n", 1, "texture coordinate 5, but the file has 0"},
      {&kObj, square + "f 1 2\nf 1 2 3\n", 1, "1 face with fewer than three corners"},
      {&kObj, square + "f 1//1 2//1 3//1\nf 1 3 4\nvn 0 0 2\n", 2, "1 triangle has no normal"},
      {&kObj, square + "f 1//1 2 3\nf 1 3 4\n", 2, "1 corner names a normal that is not there"},
      {&kObj, square + "f 1//1 2//1 3\nf 1 3 4\n", 2, "2 corners name normals that are not there"},
      {&kObj, "f 1 2 3\n" + square, 1, "come after their face"},
      {&kObj, square + "p 1\nf 1 2 3\n", 1, "1 point statement is left out"},
      {&kObj, square + "curv2 1 2\nf 1 2 3\n", 1,
       "1 statement that is not read, the first \"curv2\""},
      {&kObj, square + "mtllib ../../etc/passwd\nf 1 2 3\n", 1, "no folder to be looked for in"},
      {&kObj, square, 0, "the file has no faces"},
      {&kObj, square + "f 1 3 2 4\n", 2, "1 polygon crosses itself"},
      {&kOff, "OFF # a\n4 1 0\n0 0 0\n1 0 0 # b\n1 1 0\n\n0 1 0\n4 0 1 2 3\n", 2, ""},
      {&kOff,
       "CNOFF 3 1 0\n0 0 0 0 0 1 1.0 0.0 0.0 1.0\n1 0 0 0 0 1 1. 0. 0. 1.\n0 1 0 0 0 1 1. 0. 0. "
       "1.\n3 0 1 2\n",
       1, ""},
      {&kOff, "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\nmore", 1,
       "the text after the last of 1 face is left out"},
  };
  for (const Odd& odd : all) {
    const Outcome outcome = read(*odd.format, odd.content);
    EXPECT_TRUE(outcome.read) << odd.content << outcome.said;
    EXPECT_EQ(outcome.mesh.triangles.size(), odd.triangles) << odd.content;
    expect_sound(outcome.mesh, odd.content);
    if (*odd.warning == '\0') {
      EXPECT_EQ(outcome.said, "") << odd.content;
    } else {
      EXPECT_NE(outcome.said.find(odd.warning), std::string::npos) << odd.content << outcome.said;
    }
  }
}

TEST(MeshReader, PlyFacesOnBothSidesOfTheirVertices) {
  const std::string start =
      "ply\nformat ascii 1.0\nelement face 1\n"
      "property list uchar int vertex_indices\nproperty int normal1\n"
      "property int normal2\nproperty int normal3\nelement vertex 4\n";
  const std::string vector = "property float nx\nproperty float ny\nproperty float nz\n";
  const std::string end = "element normal 6\n" + vector +
                          "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
                          "3 0 1 2 3 4 5\n";
  const std::string position = "property float x\nproperty float y\nproperty float z\n";
  const std::string rest = "1 0 0\n0 1 0\n0 0 1\n0 1 0\n1 0 0\n0 0 1\n3 1 3 2\n";
  const Outcome outcome =
      read(kPly, start + position + vector + end +
                     "0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n1 1 0 0 0 1\n" + rest);
  ASSERT_TRUE(outcome.read) << outcome.said;
  expect_sound(outcome.mesh, "both sides");
  ASSERT_EQ(outcome.mesh.triangles.size(), 2U);
  // The strip is read first, its vertices' normals give way to those that the face counts.
  EXPECT_EQ(outcome.mesh.triangles[0], (std::array<std::uint32_t, 3>{1, 3, 2}));
  EXPECT_EQ(outcome.mesh.triangles[1], (std::array<std::uint32_t, 3>{0, 1, 2}));
  ASSERT_EQ(outcome.mesh.corner_normals.size(), 2U);
  EXPECT_EQ(outcome.mesh.normals[outcome.mesh.corner_normals[1][0]], Vec3(0, 1, 0));
  EXPECT_NE(outcome.said.find("1 triangle has no normal"), std::string::npos) << outcome.said;
}

TEST(MeshReader, PlyOfEveryTypeAndByteOrder) {
  // The same triangle with properties in another order, other types and both byte orders.
  const std::string head =
      "element vertex 3\nproperty uchar red\nproperty double z\nproperty short x\n"
      "property list uchar ushort extra\nproperty int y\nproperty uchar blue\nproperty uchar "
      "green\n"
      "element face 1\nproperty char k\nproperty list uint ushort vertex_index\nend_header\n";
  const auto swapped = [](auto value) {
    std::string raw(sizeof value, '\0');
    std::memcpy(raw.data(), &value, sizeof value);
    return std::string(raw.rbegin(), raw.rend());
  };
  const auto straight = [&](auto value) {
    const std::string raw = swapped(value);
    return std::string(raw.rbegin(), raw.rend());
  };
  const auto body = [&](auto put) {
    std::string data;
    const short x[] = {0, -7, 0};
    const int y[] = {0, 0, 70000};
    for (int i = 0; i < 3; ++i) {
      data += "\x0A";
      data += put(0.1 * i) + put(x[i]) + std::string(1, static_cast<char>(i));
      for (int k = 0; k < i; ++k) data += put(static_cast<std::uint16_t>(k));
      data += put(y[i]) + "\x03\x02";
    }
    data += "\x05" + put(std::uint32_t{3});
    for (std::uint16_t v = 0; v < 3; ++v) data += put(v);
    return data;
  };
  const std::string little = "ply\nformat binary_little_endian 1.0\n" + head + body(straight);
  const std::string big = "ply\r\nformat binary_big_endian 1.0\r\n" + head + body(swapped);
  const std::string ascii =
      "ply\nformat ascii 1.0\n" + head +
      "10 0 0 0 0 3 2\n10 .1 -7 1 0 0 3 2\n10 +2e-1 0 2 0 1 70000 3 2\n5 3 0 1 2";
  const Outcome expected = read(kPly, little);
  ASSERT_TRUE(expected.read) << expected.said;
  EXPECT_EQ(expected.mesh.positions, (std::vector<Vec3>{{0, 0, 0}, {-7, 0, 0.1}, {0, 70000, 0.2}}));
  EXPECT_EQ(expected.mesh.vertex_colors[2], (std::array<std::uint8_t, 4>{10, 2, 3, 255}));
  EXPECT_EQ(expected.mesh.triangles.size(), 1U);
  for (const std::string& other : {big, ascii}) {
    const Outcome outcome = read(kPly, other);
    ASSERT_TRUE(outcome.read) << outcome.said;
    EXPECT_EQ(outcome.mesh.positions, expected.mesh.positions);
    EXPECT_EQ(outcome.mesh.triangles, expected.mesh.triangles);
    EXPECT_EQ(outcome.mesh.vertex_colors, expected.mesh.vertex_colors);
  }
}

TEST(MeshReader, PlyElementsAndEdgesThatAreNone) {
  const auto file = [](const std::string& element, const std::string& edge) {
    return "ply\nformat ascii 1.0\ncomment element 0 A\ncomment curve 0 edge:A|\nelement vertex "
           "3\nproperty float x\n"
           "property float y\nproperty float z\nelement face 1\nproperty list uchar int "
           "vertex_indices\n"
           "property float element\nelement edge 1\nproperty float vertex1\nproperty int "
           "vertex2\nproperty float curve\n"
           "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 " +
           element + "\n" + edge + "\n";
  };
  const Outcome sound = read(kPly, file("0", "0 1 0 and more"));
  ASSERT_TRUE(sound.read) << sound.said;
  ASSERT_EQ(sound.mesh.curves.size(), 1U);
  EXPECT_EQ(sound.mesh.curves[0].kind, CurveKind::kEdge);
  EXPECT_NE(sound.said.find("1 row has more values"), std::string::npos) << sound.said;
  EXPECT_TRUE(read(kPly, file("0", "0 1 nan")).read);
  for (const char* element : {"nan", "1", "-1", "1e30"})
    EXPECT_FALSE(read(kPly, file(element, "0 1 0")).read) << element;
  for (const char* edge : {"nan 1 0", "0 3 0", "-1 1 0", "1e30 1 0"})
    EXPECT_FALSE(read(kPly, file("0", edge)).read) << edge;
}

TEST(MeshReader, MagicsColorsHaveRedInTheLowBits) {
  std::string stl = std::string("COLOR=") + "\x10\x20\x30\xFF" + ", made by hand";
  stl.resize(80, '\0');
  stl += std::string("\x02\0\0\0", 4);
  const float facet[12] = {0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0};
  for (const std::uint16_t word : {std::uint16_t{31}, std::uint16_t{0x8000}}) {
    stl.append(static_cast<const char*>(static_cast<const void*>(facet)), sizeof facet);
    stl.append(static_cast<const char*>(static_cast<const void*>(&word)), 2);
  }
  const Outcome outcome = read(kStl, stl);
  ASSERT_TRUE(outcome.read) << outcome.said;
  ASSERT_EQ(outcome.mesh.elements.size(), 2U);
  EXPECT_EQ(outcome.mesh.elements[0].color, (std::array<std::uint8_t, 4>{255, 0, 0, 255}));
  EXPECT_EQ(outcome.mesh.elements[1].color, (std::array<std::uint8_t, 4>{0x10, 0x20, 0x30, 0xFF}));
}

TEST(MeshReader, PlyNormalsOfCornersAsAListOrAsThreeNumbers) {
  const std::string vertices =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
      "property float z\nelement face 1\nproperty list uchar int vertex_indices\n";
  const std::string normals =
      "element normal 2\nproperty float nx\nproperty float ny\nproperty float nz\nend_header\n"
      "0 0 0\n1 0 0\n0 1 0\n";
  const std::string list = vertices + "property list uchar int normal_indices\n" + normals +
                           "3 0 1 2 3 1 0 1\n0 0 1\n0 1 0\n";
  const std::string numbers =
      vertices + "property int normal1\nproperty uchar normal2\nproperty int normal3\n" + normals +
      "3 0 1 2 1 0 1\n0 0 1\n0 1 0\n";
  for (const std::string& text : {list, numbers}) {
    const Outcome outcome = read(kPly, text);
    ASSERT_TRUE(outcome.read) << outcome.said;
    EXPECT_EQ(outcome.said, "");
    ASSERT_EQ(outcome.mesh.normals.size(), 2U);
    ASSERT_EQ(outcome.mesh.corner_normals.size(), 1U);
    EXPECT_EQ(outcome.mesh.corner_normals[0], (std::array<std::uint32_t, 3>{1, 0, 1}));
  }
  std::string past = numbers;
  past.replace(past.find("3 0 1 2 1 0 1"), 13, "3 0 1 2 1 0 2");
  EXPECT_NE(read(kPly, past).said.find("past the last"), std::string::npos);
}

TEST(MeshReader, LimitsHold) {
  ReadOptions options;
  options.max_triangles = 1;
  const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
  EXPECT_NE(read(kObj, square + "f 1 2 3\nf 1 3 4\n", options)
                .said.find("more triangles than the limit of 1"),
            std::string::npos);
  EXPECT_NE(read(kStl, std::string("solid\n") + kFacet + kFacet + "endsolid", options)
                .said.find("limit of 1"),
            std::string::npos);
  EXPECT_NE(read(kOff, "OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 2 1\n", options)
                .said.find("limit of 1"),
            std::string::npos);
  EXPECT_TRUE(read(kObj, square + "f 1 2 3\n", options).read);
  const std::string long_line = "v 0 0 0\nf " + std::string(std::size_t{2} << 20, '1') + "\n";
  EXPECT_FALSE(read(kObj, long_line).read);
}

TEST(MeshReader, MemoryIsBoundedByTheCountsOfTheFile) {
  const TriangleMesh torus = testing::torus_mesh(30, 40);  // 1200 vertices, 2400 triangles
  for (const Format* format : all_formats()) {
    for (const bool ascii : {false, true}) {
      WriteOptions writing;
      writing.ascii = ascii;
      const Result<WrittenMesh> written = format->write(torus, writing);
      ASSERT_TRUE(written);
      const std::string text(
          static_cast<const char*>(static_cast<const void*>(written->files[0].bytes.data())),
          written->files[0].bytes.size());
      ReadOptions options;
      options.max_memory = std::size_t{1200} * 24 + 2400 * 12 - 1;
      const Outcome refused = read(*format, text, options);
      EXPECT_FALSE(refused.read) << format->id << ascii;
      EXPECT_NE(refused.said.find("memory"), std::string::npos) << format->id << refused.said;
      options.max_memory = std::size_t{1} << 20;
      EXPECT_TRUE(read(*format, text, options).read) << format->id << ascii;
    }
  }
}

// Small valid files of every format and kind.
std::vector<std::pair<const Format*, std::string>> samples() {
  std::vector<std::pair<const Format*, std::string>> all;
  for (const Format* format : {&kStl, &kObj, &kPly, &kOff}) {
    for (const bool ascii : {false, true}) {
      testing::MeshTraits traits;
      TriangleMesh mesh = testing::random_mesh(3, traits);
      mesh.triangles.resize(8);
      if (!mesh.triangle_element.empty()) mesh.triangle_element.resize(8);
      mesh.corner_normals.resize(8);
      WriteOptions options;
      options.program_comment = "diesink";
      options.ascii = ascii;
      options.lines = true;
      options.file_stem = "s";
      const Result<WrittenMesh> written = format->write(mesh, options);
      EXPECT_TRUE(written);
      const std::vector<std::byte>& bytes = written->files[0].bytes;
      all.emplace_back(format,
                       std::string(static_cast<const char*>(static_cast<const void*>(bytes.data())),
                                   bytes.size()));
    }
  }
  return all;
}

TEST(MeshReader, AFileCutAnywhereIsRefusedOrSound) {
  for (const auto& [format, content] : samples()) {
    const bool binary = content.find('\0') != std::string::npos;
    for (std::size_t size = 0; size < content.size(); ++size) {
      const Outcome outcome = read(*format, content.substr(0, size));
      const std::string what = std::string(format->id) + " cut at " + std::to_string(size);
      if (outcome.read) expect_sound(outcome.mesh, what);
      if (binary) {
        EXPECT_FALSE(outcome.read) << what;
      }
    }
  }
}

TEST(MeshReader, AFileWithABitFlippedIsRefusedOrSound) {
  for (const auto& [format, content] : samples()) {
    for (std::size_t bit = 0; bit < 8 * content.size(); ++bit) {
      std::string spoiled = content;
      spoiled[bit / 8] = static_cast<char>(spoiled[bit / 8] ^ (1 << (bit % 8)));
      const Outcome outcome = read(*format, spoiled);
      if (outcome.read)
        expect_sound(outcome.mesh, std::string(format->id) + " bit " + std::to_string(bit));
    }
  }
}

TEST(MeshReader, WordsExchangedAreRefusedOrSound) {
  // Mutation by structure: numbers and keywords put in each other's places.
  const std::vector<std::string> words{"-1",
                                       "0",
                                       "1",
                                       "2147483647",
                                       "4294967295",
                                       "1e308",
                                       "nan",
                                       "3",
                                       "",
                                       "v",
                                       "f",
                                       "endsolid",
                                       "end_header",
                                       "\\",
                                       "#",
                                       "l",
                                       "99999999999999999999",
                                       "1/2/3",
                                       "-2//-2"};
  std::mt19937_64 random(7);
  for (const auto& [format, content] : samples()) {
    for (int round = 0; round < 600; ++round) {
      std::string spoiled = content;
      for (std::size_t edits = 1 + random() % 3; edits > 0; --edits) {
        const std::size_t at = random() % spoiled.size();
        std::size_t first = at, last = at;
        while (first > 0 && !std::isspace(static_cast<unsigned char>(spoiled[first - 1]))) --first;
        while (last < spoiled.size() && !std::isspace(static_cast<unsigned char>(spoiled[last])))
          ++last;
        spoiled.replace(first, last - first, words[random() % words.size()]);
      }
      if (spoiled.empty()) continue;
      const Outcome outcome = read(*format, spoiled);
      if (outcome.read)
        expect_sound(outcome.mesh, std::string(format->id) + " " + std::to_string(round));
    }
  }
}

TEST(MeshReader, ContentTellsTheFormat) {
  for (const auto& [format, content] : samples()) {
    EXPECT_EQ(format_of_content(bytes_of(content), "noname"), format);
    EXPECT_EQ(format_of_content(bytes_of(content), "wrong.txt"), format);
    EXPECT_EQ(format_of_content(bytes_of("\n \n" + content), "a.obj")->id.empty(), false);
  }
  EXPECT_EQ(format_of_content(bytes_of("hello"), "a.STL"), &kStl);
  EXPECT_EQ(format_of_content(bytes_of("hello"), "a.txt"), nullptr);
  EXPECT_EQ(format_of_ending("folder.stl/file"), nullptr);
  EXPECT_EQ(format_of_ending("a.b.PLY"), &kPly);
}

}  // namespace
}  // namespace diesink
