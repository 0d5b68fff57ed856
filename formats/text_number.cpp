// SPDX-License-Identifier: Apache-2.0
#include "formats/text_number.h"

#include <array>
#include <cassert>
#include <charconv>
#include <cmath>

namespace diesink {
namespace {

constexpr std::array<double, 23> kPowersOfTen{1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                              1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                              1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

bool is_digit(char c) { return static_cast<unsigned char>(c - '0') < 10; }

// from_chars says "out of range" for both ends; the decimal place of the first digit tells which.
bool is_tiny(const char* first, const char* last) {
  long place = 0;  // of the leading non-zero digit
  bool seen = false, after_point = false;
  for (; first != last && (is_digit(*first) || *first == '.'); ++first) {
    if (*first == '.') {
      after_point = true;
    } else if (seen) {
      place += after_point ? 0 : 1;
    } else {
      seen = *first != '0';
      place -= after_point ? 1 : 0;
    }
  }
  long exponent = 0;
  if (first != last) {
    ++first;
    const bool negative = first != last && *first == '-';
    if (first != last && (*first == '-' || *first == '+')) ++first;
    for (; first != last && is_digit(*first) && exponent < 1'000'000; ++first) {
      exponent = exponent * 10 + (*first - '0');
    }
    if (negative) exponent = -exponent;
  }
  return place + exponent < 0;
}

template <class Real>
char* put_shortest(char* at, Real value) {
  assert(std::isfinite(value));
  // Adding zero turns -0 into 0 and changes nothing else.
  return std::to_chars(at, at + kMaxNumberText, value + Real{0}).ptr;
}

}  // namespace

char* put_number(char* at, double value) { return put_shortest(at, value); }
char* put_number(char* at, float value) { return put_shortest(at, value); }

char* put_integer(char* at, std::uint64_t value) {
  return std::to_chars(at, at + kMaxNumberText, value).ptr;
}

char* put_fixed(char* at, double value, int decimals) {
  assert(std::abs(value) < 1e15 && decimals >= 0 && decimals <= 15);
  // 15 digits, a point and 15 decimals stay within the room; a rounded-away sign must not remain.
  char* end = std::to_chars(at, at + kMaxNumberText, value, std::chars_format::fixed, decimals).ptr;
  if (decimals > 0) {
    while (end[-1] == '0') --end;
    if (end[-1] == '.') --end;
  }
  if (end - at == 2 && at[0] == '-' && at[1] == '0') {
    at[0] = '0';
    --end;
  }
  return end;
}

std::string to_text(double value) {
  std::array<char, kMaxNumberText> text{};
  return {text.data(), put_number(text.data(), value)};
}

std::string to_text(float value) {
  std::array<char, kMaxNumberText> text{};
  return {text.data(), put_number(text.data(), value)};
}

std::string to_text(std::uint64_t value) {
  std::array<char, kMaxNumberText> text{};
  return {text.data(), put_integer(text.data(), value)};
}

NumberAt read_number(const char* first, const char* last, double& value) {
  const char* at = first;
  const bool negative = at != last && *at == '-';
  if (at != last && (*at == '-' || *at == '+')) ++at;
  const char* const unsigned_start = at;

  // Short numbers, nearly all there are: a mantissa below 2^53 and a small power of ten multiply or
  // divide to the correctly rounded value in one operation (Clinger 1990).
  std::uint64_t mantissa = 0;
  int digits = 0, scale = 0;
  for (; at != last && is_digit(*at); ++at, ++digits) {
    mantissa = mantissa * 10 + static_cast<std::uint64_t>(*at - '0');
  }
  int all_digits = digits;
  if (at != last && *at == '.') {
    ++at;
    const char* const fraction = at;
    for (; at != last && is_digit(*at); ++at) {
      mantissa = mantissa * 10 + static_cast<std::uint64_t>(*at - '0');
    }
    scale = -static_cast<int>(at - fraction);
    all_digits += static_cast<int>(at - fraction);
  }
  if (all_digits == 0) {
    const char letter = unsigned_start == last ? '\0' : *unsigned_start;
    const bool word = letter == 'n' || letter == 'N' || letter == 'i' || letter == 'I';
    return {unsigned_start, word ? NumberState::kNotFinite : NumberState::kNotANumber};
  }
  if (at != last && (*at == 'e' || *at == 'E')) {
    const char* power = at + 1;
    const bool power_negative = power != last && *power == '-';
    if (power != last && (*power == '-' || *power == '+')) ++power;
    if (power != last && is_digit(*power)) {
      int exponent = 0;
      for (; power != last && is_digit(*power); ++power) {
        if (exponent < 100'000) exponent = exponent * 10 + (*power - '0');
      }
      scale += power_negative ? -exponent : exponent;
      at = power;
    }
  }
  if (all_digits <= 19 && mantissa <= (std::uint64_t{1} << 53) && scale >= -22 && scale <= 22) {
    const double whole = static_cast<double>(mantissa);
    const double size = scale < 0 ? whole / kPowersOfTen[static_cast<std::size_t>(-scale)]
                                  : whole * kPowersOfTen[static_cast<std::size_t>(scale)];
    value = negative && size != 0 ? -size : size;
    return {at, NumberState::kOk};
  }

  double size = 0;
  const std::from_chars_result read = std::from_chars(unsigned_start, at, size);
  if (read.ec == std::errc::result_out_of_range) {
    if (!is_tiny(unsigned_start, at)) return {at, NumberState::kTooLarge};
    size = 0;
  } else if (read.ec != std::errc{}) {
    return {at, NumberState::kNotANumber};
  }
  if (!std::isfinite(size)) return {at, NumberState::kTooLarge};
  value = negative && size != 0 ? -size : size;
  return {at, NumberState::kOk};
}

std::optional<double> number_of(std::string_view word) {
  double value = 0;
  const NumberAt read = read_number(word.data(), word.data() + word.size(), value);
  if (read.state != NumberState::kOk || read.end != word.data() + word.size()) return std::nullopt;
  return value;
}

std::optional<std::int64_t> integer_of(std::string_view word) {
  if (!word.empty() && word.front() == '+') {
    word.remove_prefix(1);
    if (!word.empty() && word.front() == '-') return std::nullopt;
  }
  std::int64_t value = 0;
  const char* const end = word.data() + word.size();
  const std::from_chars_result read = std::from_chars(word.data(), end, value);
  if (word.empty() || read.ec != std::errc{} || read.ptr != end) return std::nullopt;
  return value;
}

}  // namespace diesink
