// Numbers as text against the C library's own reading and printing.
// SPDX-License-Identifier: Apache-2.0
#include "formats/text_number.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <random>
#include <string>
#include <string_view>

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

template <class Real>
void expect_the_librarys(Real value) {
  // What is behind the room must stay as it is.
  std::array<char, kMaxNumberText + 8> own{};
  std::array<char, kMaxNumberText> theirs{};
  const char* const end = put_number(own.data(), value);
  const char* const their_end =
      std::to_chars(theirs.data(), theirs.data() + theirs.size(), value + Real{0}).ptr;
  ASSERT_EQ(std::string_view(own.data(), static_cast<std::size_t>(end - own.data())),
            std::string_view(theirs.data(), static_cast<std::size_t>(their_end - theirs.data())));
  for (std::size_t i = kMaxNumberText; i < own.size(); ++i) ASSERT_EQ(own[i], '\0') << value;
}

TEST(TextNumber, ShortestAndNearestAsTheLibraryWrites) {
  std::mt19937_64 random(11);
  const auto expect_both = [](double value) {
    for (const double each : {value, -value}) {
      expect_the_librarys(each);
      if (std::abs(each) < 1e38) expect_the_librarys(static_cast<float>(each));
    }
  };
  for (int i = 0; i < 60'000 && !::testing::Test::HasFatalFailure(); ++i) {
    const double part = 1 + std::ldexp(static_cast<double>(random() >> 12), -52);
    expect_both(std::ldexp(part, static_cast<int>(random() % 150) - 110));
    expect_both(static_cast<double>(random() % 2'000'000'000) / 1e4);  // short decimals
    expect_both(static_cast<double>(random() % 1'000'000) *
                std::pow(10, -static_cast<int>(random() % 16)));
    expect_both(std::ldexp(static_cast<double>(random() % 4096), -static_cast<int>(random() % 60)));
    // Halfway between two decimals of 16 digits, and between whole numbers.
    expect_both(std::ldexp(std::ldexp(part, 52), -static_cast<int>(random() % 7)));
    expect_the_librarys(static_cast<float>(std::ldexp(part, 23 - static_cast<int>(random() % 7))));
  }
  // Beside powers of two, where numbers are not equally far, and of ten.
  for (int power = -120; power < 80; ++power) {
    for (const double near : {std::ldexp(1.0, power), std::pow(10.0, power / 4)}) {
      double below = near, above = near;
      for (int step = 0; step < 4; ++step) {
        expect_both(below);
        expect_both(above);
        below = std::nextafter(below, 0.0);
        above = std::nextafter(above, 1e300);
      }
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

// Between two doubles: (2^53 + odd) / 2^k and · 2^k, whose decimals still fit in 64 bits, and their
// neighbours by one in the last decimal.
TEST(TextNumber, HalfwayBetweenTwoDoublesGoesToTheEvenOne) {
  std::mt19937_64 random(7);
  std::uint64_t five = 1;
  for (int k = 0; k <= 4; ++k, five *= 5) {
    for (int i = 0; i < 2000; ++i) {
      const std::uint64_t odd = (std::uint64_t{1} << 53) + 2 * (random() % 100'000'000'000'000) + 1;
      if (odd > 18'446'744'073'709'551'614U / five) continue;
      for (int by = -1; by <= 1; ++by) {
        const std::uint64_t mantissa = odd * five + static_cast<std::uint64_t>(by);
        for (const int scale : {-k, -k - 20, k, 17 + k, -27, 27}) {
          const std::string text = std::to_string(mantissa) + "e" + std::to_string(scale);
          EXPECT_EQ(number_of(text), std::strtod(text.c_str(), nullptr)) << text;
        }
      }
    }
  }
  EXPECT_EQ(number_of("9007199254740993"), 9007199254740992.0);
  EXPECT_EQ(number_of("9007199254740993.0000"), 9007199254740992.0);
  EXPECT_EQ(number_of("9007199254740995"), 9007199254740996.0);
  EXPECT_EQ(number_of("00000000000000000000000000.1"), 0.1);
  EXPECT_EQ(number_of("0.000000000000000000000001234567890123456789"), 1.234567890123456789e-24);
}

// Digits are read eight at a time where there are as many bytes: every length, followed by
// anything.
TEST(TextNumber, EndsAtTheFirstByteThatIsNoDigit) {
  for (std::size_t digits = 1; digits <= 19; ++digits) {
    for (int c = 0; c < 256; ++c) {
      const auto byte = static_cast<char>(c);
      if ((c >= '0' && c <= '9') || byte == '.' || byte == 'e' || byte == 'E') continue;
      const std::string text = std::string("1234567890123456789").substr(0, digits) + byte;
      for (const std::string& tail : {std::string(), std::string("12345678")}) {
        double value = 0;
        const std::string all = text + tail;
        const NumberAt read = read_number(all.data(), all.data() + all.size(), value);
        EXPECT_EQ(read.state, NumberState::kOk);
        EXPECT_EQ(read.end - all.data(), static_cast<std::ptrdiff_t>(digits)) << c;
        EXPECT_EQ(value, std::strtod(text.substr(0, digits).c_str(), nullptr));
      }
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

TEST(TextNumber, IntegersAreWrittenAsTheLibraryDoes) {
  std::mt19937_64 random(8);
  const auto check = [](std::uint64_t value) { ASSERT_EQ(to_text(value), std::to_string(value)); };
  for (std::uint64_t value = 0; value < 120'000; ++value) check(value);
  for (std::uint64_t ten = 1; ten < 10'000'000'000'000'000'000U; ten *= 10) {
    for (std::uint64_t value : {ten - 1, ten, ten + 1, 2 * ten - 1, 9 * (ten / 10)}) check(value);
  }
  for (int i = 0; i < 300'000; ++i) check(random() >> random() % 64);
  check(~std::uint64_t{0});
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
