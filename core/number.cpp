// SPDX-License-Identifier: Apache-2.0
#include "core/number.h"

#include <algorithm>
#include <charconv>
#include <system_error>

namespace diesink {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }
char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

bool is_word(std::string_view text, std::string_view word) {
  return std::equal(text.begin(), text.end(), word.begin(), word.end(),
                    [](char a, char b) { return lower(a) == b; });
}

}  // namespace

NumberFault read_number(std::string_view text, double& value) {
  const bool negative = !text.empty() && text.front() == '-';
  if (!text.empty() && (text.front() == '-' || text.front() == '+')) text.remove_prefix(1);
  if (is_word(text, "nan") || is_word(text, "inf") || is_word(text, "infinity")) {
    return NumberFault::kNotFinite;
  }

  // The grammar is checked here: from_chars alone would stop at a D and take hexadecimal-like tails
  // as the end.
  std::size_t at = 0, digits = 0;
  // Decimal place of the first digit that is not zero: tells an overflow from an underflow.
  long long leading = 0;
  bool nonzero = false;
  for (; at < text.size() && is_digit(text[at]); ++at, ++digits) {
    nonzero = nonzero || text[at] != '0';
    if (nonzero) ++leading;
  }
  if (at < text.size() && text[at] == '.') {
    for (++at; at < text.size() && is_digit(text[at]); ++at, ++digits) {
      if (!nonzero) {
        if (text[at] == '0') --leading;
        nonzero = text[at] != '0';
      }
    }
  }
  if (digits == 0) return NumberFault::kNotANumber;
  const std::size_t mantissa_end = at;
  long long exponent = 0;
  if (at < text.size()) {
    const char mark = lower(text[at]);
    if (mark != 'e' && mark != 'd') return NumberFault::kNotANumber;
    ++at;
    const bool down = at < text.size() && text[at] == '-';
    if (at < text.size() && (text[at] == '-' || text[at] == '+')) ++at;
    if (at == text.size()) return NumberFault::kNotANumber;
    constexpr long long kEnough = 1'000'000'000'000;  // beyond what any mantissa of a file can undo
    for (; at < text.size(); ++at) {
      if (!is_digit(text[at])) return NumberFault::kNotANumber;
      exponent = std::min(kEnough, exponent * 10 + (text[at] - '0'));
    }
    if (down) exponent = -exponent;
  }
  if (!nonzero) {
    value = 0;
    return NumberFault::kNone;
  }

  std::string plain(text.substr(0, mantissa_end));
  if (exponent != 0) plain += 'e' + std::to_string(exponent);
  double magnitude = 0;
  const std::from_chars_result read =
      std::from_chars(plain.data(), plain.data() + plain.size(), magnitude);
  if (read.ec == std::errc::result_out_of_range) {
    if (leading + exponent > 0) return NumberFault::kTooLarge;
    magnitude = 0;
  }
  value = negative && magnitude != 0 ? -magnitude : magnitude;
  return NumberFault::kNone;
}

std::string number_text(double value) {
  char buffer[40];
  const std::to_chars_result end =
      std::to_chars(buffer, buffer + sizeof buffer, value == 0 ? 0.0 : value);
  return {buffer, end.ptr};
}

}  // namespace diesink
