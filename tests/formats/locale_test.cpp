// A locale that writes 1,5 changes no byte that is written and no number that is read.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <clocale>
#include <cstdio>
#include <string>
#include <vector>

#include "formats/json_writer.h"
#include "formats/registry.h"
#include "formats/text_number.h"
#include "tests/support/mesh_signature.h"
#include "tests/support/random_mesh.h"

namespace diesink {
namespace {

class DecimalComma : public ::testing::Test {
 protected:
  void SetUp() override {
    if (std::setlocale(LC_ALL, "de_DE.UTF-8") == nullptr) {
      // The build makes the locale wherever it can.
      ASSERT_FALSE(DIESINK_HAS_COMMA_LOCALE) << "de_DE.UTF-8 was made, but is not found";
      std::puts("skipped: there is no locale de_DE.UTF-8 (Debian package locales)");
      GTEST_SKIP();
    }
    char text[8];
    std::snprintf(text, sizeof text, "%.1f", 1.5);
    ASSERT_STREQ(text, "1,5") << "the locale is not in force";
  }
  void TearDown() override { std::setlocale(LC_ALL, "C"); }
};

std::vector<std::vector<std::byte>> bytes_of_all(const TriangleMesh& mesh) {
  std::vector<std::vector<std::byte>> all;
  for (const Format* format : all_formats()) {
    for (const bool variant : {false, true}) {
      WriteOptions options;
      options.ascii = variant;
      options.draco = variant;
      options.lines = true;
      const Result<WrittenMesh> written = format->write(mesh, options);
      EXPECT_TRUE(written) << format->id;
      if (written) all.push_back(written->files[0].bytes);
    }
  }
  return all;
}

std::vector<TriangleMesh> read_all(const std::vector<std::vector<std::byte>>& files) {
  std::vector<TriangleMesh> all;
  for (const std::vector<std::byte>& file : files) {
    Diagnostics diagnostics;
    Result<TriangleMesh> mesh = format_of_content(file, "")->read(file, {}, diagnostics);
    EXPECT_TRUE(mesh) << to_text(mesh.error());
    if (mesh) all.push_back(std::move(*mesh));
  }
  return all;
}

TEST_F(DecimalComma, MeshesAreWrittenAndReadTheSame) {
  testing::MeshTraits traits;
  traits.vertex_colors = false;  // Draco's are not of interest here
  const TriangleMesh mesh = testing::random_mesh(5, traits);
  const std::vector<std::vector<std::byte>> with_comma = bytes_of_all(mesh);
  const std::vector<TriangleMesh> read_with_comma = read_all(with_comma);
  std::setlocale(LC_ALL, "C");
  EXPECT_TRUE(bytes_of_all(mesh) == with_comma);
  const std::vector<TriangleMesh> read_without = read_all(with_comma);
  ASSERT_EQ(read_without.size(), read_with_comma.size());
  for (std::size_t i = 0; i < read_without.size(); ++i) {
    EXPECT_EQ(testing::difference(testing::signature(read_without[i], {}),
                                  testing::signature(read_with_comma[i], {})),
              "");
  }
}

TEST_F(DecimalComma, NumbersKeepTheirPoint) {
  EXPECT_EQ(to_text(0.5), "0.5");
  JsonWriter json;
  json.begin_array().value(0.5).end_array();
  EXPECT_NE(json.text().find("0.5"), std::string::npos);
  const std::string text = "v 0.5 1.5 2.5\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  Diagnostics diagnostics;
  const Result<TriangleMesh> mesh = kObj.read(std::as_bytes(std::span(text)), {}, diagnostics);
  ASSERT_TRUE(mesh);
  EXPECT_EQ(mesh->positions[0], Vec3(0.5, 1.5, 2.5));
}

}  // namespace
}  // namespace diesink
