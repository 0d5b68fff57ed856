// Numbers of the input language: text to double and back, never by the locale.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace diesink {

enum class NumberFault : std::uint8_t {
  kNone,
  kNotANumber,  // anything that is not a decimal number from end to end
  kNotFinite,   // the words nan, inf, infinity, with or without sign
  kTooLarge,    // a decimal number beyond the range of double
};

// `30`, `.8`, `-1`, `1.5E-3`, `+2.`, `1.D0`: a decimal number that fills the whole text, blanks
// excluded. E and D, in either case, begin the exponent. A number too small for a double reads as
// 0; -0 reads as 0. On a fault `value` is left alone.
NumberFault read_number(std::string_view text, double& value);

// The shortest text that reads back as the same double; never "-0".
std::string number_text(double value);

}  // namespace diesink
