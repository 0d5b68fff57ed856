// Numbers as text against the C library's own reading and printing.
// SPDX-License-Identifier: Apache-2.0
#include "formats/text_number.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <random>
#include <string>

namespace diesink {
namespace {

TEST(TextNumber, WhatIsWrittenReadsBackToTheBit) {
  std::mt19937_64 random(5);
  for (int i = 0; i < 200'000; ++i) {
    double value = 0;
    if (i % 3 == 0) {
      value = std::bit_cast<double>(random());
    } else {
      value = static_cast<double>(static_cast<std::int64_t>(random() % 2'000'001) - 1'000'000) /
              (i % 3 == 1 ? 1000 : 7);
    }
    if (!std::isfinite(value)) continue;
    const std::string text = to_text(value);
    EXPECT_EQ(number_of(text), value) << text;
    EXPECT_EQ(std::strtod(text.c_str(), nullptr), value) << text;
    const auto narrow = static_cast<float>(value);
    if (std::isfinite(narrow)) {
      EXPECT_EQ(std::strtof(to_text(narrow).c_str(), nullptr), narrow);
    }
  }
}

TEST(TextNumber, ReadsAsTheCLibraryDoes) {
  std::mt19937_64 random(6);
  for (int i = 0; i < 200'000; ++i) {
    std::string text(random() % 2 == 0 ? "-" : "");
    for (std::size_t d = 1 + random() % 22; d > 0; --d)
      text += static_cast<char>('0' + random() % 10);
    if (random() % 3 != 0) text.insert(text.size() - random() % text.size(), ".");
    if (text.find('-') != 0 || text[1] != '.') {
      if (random() % 3 == 0) text += "e" + std::to_string(static_cast<int>(random() % 640) - 330);
    }
    const double expected = std::strtod(text.c_str(), nullptr);
    double value = -1;
    const NumberAt read = read_number(text.data(), text.data() + text.size(), value);
    if (text.find_first_of("0123456789") > 2 && read.state == NumberState::kNotANumber) continue;
    EXPECT_EQ(read.end, text.data() + text.size()) << text;
    if (std::isinf(expected)) {
      EXPECT_EQ(read.state, NumberState::kTooLarge) << text;
    } else {
      ASSERT_EQ(read.state, NumberState::kOk) << text;
      EXPECT_EQ(value, expected) << text;
      EXPECT_FALSE(value == 0 && std::signbit(value)) << text;
    }
  }
}

TEST(TextNumber, SaysWhatIsNone) {
  const auto state = [](std::string_view text) {
    double value = 0;
    return read_number(text.data(), text.data() + text.size(), value).state;
  };
  for (const char* word : {"", "-", "+", ".", "-.", "e5", "x", ",5", "+-1"}) {
    EXPECT_EQ(state(word), NumberState::kNotANumber) << word;
  }
  for (const char* word : {"nan", "-inf", "Infinity", "NaN", "+INF"})
    EXPECT_EQ(state(word), NumberState::kNotFinite) << word;
  EXPECT_EQ(state("1e309"), NumberState::kTooLarge);
  EXPECT_EQ(state("1e99999999999999999999"), NumberState::kTooLarge);
  EXPECT_EQ(number_of("1e-99999999999999999999"), 0.0);
  EXPECT_EQ(number_of("+1.5"), 1.5);
  EXPECT_EQ(number_of(".5"), 0.5);
  EXPECT_EQ(number_of("5."), 5.0);
  EXPECT_EQ(number_of("0x10"), std::nullopt);
  EXPECT_EQ(number_of("1,5"), std::nullopt);
  EXPECT_EQ(number_of("1e"), std::nullopt);
  EXPECT_EQ(integer_of("+7"), 7);
  EXPECT_EQ(integer_of("+-7"), std::nullopt);
  EXPECT_EQ(integer_of("9223372036854775808"), std::nullopt);
  EXPECT_EQ(integer_of(""), std::nullopt);
}

TEST(TextNumber, FixedHasNoExponentAndNoNegativeZero) {
  const auto fixed = [](double value, int decimals) {
    char text[kMaxNumberText];
    return std::string(text, put_fixed(text, value, decimals));
  };
  EXPECT_EQ(fixed(12.5, 3), "12.5");
  EXPECT_EQ(fixed(-0.0004, 3), "0");
  EXPECT_EQ(fixed(-0.0006, 3), "-0.001");
  EXPECT_EQ(fixed(100, 0), "100");
  EXPECT_EQ(fixed(-0.4, 0), "0");
  EXPECT_EQ(fixed(999999999999999, 15), "999999999999999");
  EXPECT_EQ(fixed(1e-9, 6), "0");
  EXPECT_EQ(to_text(-0.0), "0");
}

}  // namespace
}  // namespace diesink
