// Lines counted many bytes at a time, against one by one. SPDX-License-Identifier: Apache-2.0
#include "formats/plain_lines.h"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

namespace {

using namespace diesink;

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines(1);
  for (const char c : text) {
    if (c == '\n') {
      lines.emplace_back();
    } else {
      lines.back() += c;
    }
  }
  if (lines.back().empty()) lines.pop_back();
  return lines;
}

std::string random_text(const std::vector<std::string>& pieces, std::size_t count,
                        std::mt19937_64& random) {
  std::string text;
  for (std::size_t i = 0; i < count; ++i) text += pieces[random() % pieces.size()];
  return text;
}

TEST(PlainLines, RowsAreCountedOrLeftToOthers) {
  std::mt19937_64 random(1);
  const std::vector<std::string> usual{"3 1 2 3\n", "1.5 -2 7e3\n", "0\n", "12345678 87654321 "};
  const std::vector<std::string> odd{"\n", " ", "#", "\r", "\t", "\x01"};
  std::size_t counted = 0;
  for (std::size_t count = 0; count < 300; ++count) {
    std::string text = random_text(usual, count, random);
    ASSERT_EQ(plain_row_count(text), lines_of(text).size()) << text;
    ++counted;
    const std::size_t at = random() % (text.size() + 1);
    const std::string& piece = odd[random() % odd.size()];
    text.insert(at, piece);
    const auto found = plain_row_count(text);
    const std::vector<std::string> lines = lines_of(text);
    bool plain = text.find_first_of("#\r\t\x01") == std::string::npos;
    for (const std::string& line : lines) plain = plain && !line.empty() && line.front() != ' ';
    ASSERT_EQ(found.has_value(), plain) << text;
    if (!plain) continue;
    ASSERT_EQ(*found, lines.size()) << text;
  }
  EXPECT_EQ(counted, 300U);
}

TEST(PlainLines, ObjStatementsAreCountedOrLeftToOthers) {
  std::mt19937_64 random(2);
  const std::vector<std::string> usual{"v 1 2 3\n",   "vn 0 0 1\n", "vt 0 1\n", "f 1 2 3\n",
                                       "g v vn vt\n", "usemtl v\n", "# v\n",    "\n"};
  const std::vector<std::string> odd{"\\", "\r", "\t", " v 1\n", "vp 1\n", "v\n", "vn\n"};
  for (std::size_t count = 0; count < 300; ++count) {
    std::string text = random_text(usual, count, random);
    ObjCounts expected;
    for (const std::string& line : lines_of(text)) {
      expected.vertices += line.starts_with("v ") ? 1 : 0;
      expected.textures += line.starts_with("vt ") ? 1 : 0;
      expected.normals += line.starts_with("vn ") ? 1 : 0;
    }
    const auto found = plain_obj_counts(text);
    ASSERT_TRUE(found) << text;
    ASSERT_EQ(found->vertices, expected.vertices) << text;
    ASSERT_EQ(found->textures, expected.textures) << text;
    ASSERT_EQ(found->normals, expected.normals) << text;
    // At the start of a line, or anywhere where it is no statement.
    const std::string& piece = odd[random() % odd.size()];
    const std::size_t at = random() % (text.size() + 1);
    const std::size_t line = at == 0 ? 0 : text.rfind('\n', at - 1) + 1;
    text.insert(piece.size() > 1 ? line : at, piece);
    ASSERT_FALSE(plain_obj_counts(text)) << text;
  }
}

}  // namespace
