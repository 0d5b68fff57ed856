// The word that was probably meant: edits counted by hand, and limits.
// SPDX-License-Identifier: Apache-2.0
#include "core/nearest.h"

#include <gtest/gtest.h>

#include <array>
#include <string>

namespace diesink {
namespace {

constexpr std::array<std::string_view, 4> kWords{"export", "cc", "convert", "formats"};

TEST(NearestWord, CountsOneEditOfEachKind) {
  EXPECT_EQ(nearest_word("exprot", kWords), 0u);    // neighbours swapped
  EXPECT_EQ(nearest_word("expor", kWords), 0u);     // one missing
  EXPECT_EQ(nearest_word("convvert", kWords), 2u);  // one too many
  EXPECT_EQ(nearest_word("formatz", kWords), 3u);   // one replaced
  EXPECT_EQ(nearest_word("CONVERT", kWords), 2u);   // letter case is no edit
}

TEST(NearestWord, GivesNothingThatIsTooFar) {
  EXPECT_EQ(nearest_word("tessellate", kWords), std::nullopt);
  EXPECT_EQ(nearest_word("cl", kWords), 1u);            // one edit is always allowed
  EXPECT_EQ(nearest_word("xy", kWords), std::nullopt);  // two of two letters are not
  EXPECT_EQ(nearest_word("exqqqt", kWords), std::nullopt);
}

TEST(NearestWord, TakesTheFirstOfEquals) {
  constexpr std::array<std::string_view, 2> kBoth{"bat", "cat"};
  EXPECT_EQ(nearest_word("rat", kBoth), 0u);
}

TEST(NearestWord, EmptyHugeAndNoneKnown) {
  EXPECT_EQ(nearest_word("", kWords), std::nullopt);
  EXPECT_EQ(nearest_word(std::string(1'000'000, 'x'), kWords), std::nullopt);
  EXPECT_EQ(nearest_word("export", {}), std::nullopt);
}

}  // namespace
}  // namespace diesink
