// Numbers as text, both ways, whatever the locale.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace diesink {

// Room a number of any kind needs at most.
inline constexpr std::size_t kMaxNumberText = 32;

// Writes the shortest form that reads back the same value, e.g. "0.1", "-3", "1e+30"; -0 is written
// "0". Needs:  value finite; kMaxNumberText bytes at `at`. Shape:  returns one past the last byte;
// no terminating zero.
char* put_number(char* at, double value);
char* put_number(char* at, float value);

// As put_number, never with an exponent and with at most `decimals` digits after the point,
// trailing zeros cut
// ("12.5", "-0.001", "7"); a value that rounds to zero is "0".
// Needs: |value| < 1e15, 0 <= decimals <= 15.
char* put_fixed(char* at, double value, int decimals);

char* put_integer(char* at, std::uint64_t value);

// The same as strings.
std::string to_text(double value);
std::string to_text(float value);
std::string to_text(std::uint64_t value);

enum class NumberState : std::uint8_t { kOk, kNotANumber, kTooLarge, kNotFinite };

struct NumberAt {
  const char* end = nullptr;  // one past what was read
  NumberState state = NumberState::kNotANumber;
};

// Reads the decimal number that starts at `first`: [+-] digits [. digits] [e [+-] digits]. A number
// too small to be held becomes zero of its sign, -0 becomes 0. Correctly rounded. Errors:
// kNotFinite for words that begin like nan or inf, kTooLarge where the value overflows; `value` is
// untouched.
NumberAt read_number(const char* first, const char* last, double& value);

// The number that is the whole word; nothing where it is not one.
std::optional<double> number_of(std::string_view word);
std::optional<std::int64_t> integer_of(std::string_view word);

}  // namespace diesink
