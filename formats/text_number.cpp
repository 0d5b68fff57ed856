// SPDX-License-Identifier: Apache-2.0
#include "formats/text_number.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>

namespace diesink {
namespace {

constexpr std::array<double, 23> kPowersOfTen{1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                              1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                              1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

constexpr int kMostFives = 27;  // 5^27 < 2^63
constexpr std::array<std::uint64_t, kMostFives + 1> kPowersOfFive = [] {
  std::array<std::uint64_t, kMostFives + 1> powers{1};
  for (std::size_t i = 1; i < powers.size(); ++i) powers[i] = 5 * powers[i - 1];
  return powers;
}();

constexpr std::array<std::uint64_t, 17> kWholePowersOfTen = [] {
  std::array<std::uint64_t, 17> powers{1};
  for (std::size_t i = 1; i < powers.size(); ++i) powers[i] = 10 * powers[i - 1];
  return powers;
}();

__extension__ typedef unsigned __int128 UInt128;

bool is_digit(char c) { return static_cast<unsigned char>(c - '0') < 10; }

// Appends the digits at `at` to `number`, modulo 2^64, and goes behind them: eight at a time, each
// a byte of one word.
inline void read_digits(const char*& at, const char* last, std::uint64_t& number) {
  if constexpr (std::endian::native == std::endian::little) {
    while (last - at >= 8) {
      std::uint64_t word = 0;
      std::memcpy(&word, at, 8);
      word ^= 0x3030303030303030U;  // digits become 0..9
      // The top bit of every byte that is no digit; bytes do not carry into one another.
      const std::uint64_t others =
          (((word & 0x7F7F7F7F7F7F7F7FU) + 0x7676767676767676U) | word) & 0x8080808080808080U;
      const int count = others == 0 ? 8 : std::countr_zero(others) / 8;
      if (count == 0) return;
      // The digits to the end of the word, zeros before them; then pairs, fours and eights.
      word <<= 64 - 8 * count;
      word = (word * 10 + (word >> 8)) & 0x00FF00FF00FF00FFU;
      word = (word * 100 + (word >> 16)) & 0x0000FFFF0000FFFFU;
      word = (word * 10000 + (word >> 32)) & 0xFFFFFFFFU;
      number = number * kWholePowersOfTen[static_cast<std::size_t>(count)] + word;
      at += count;
      if (count < 8) return;
    }
  }
  for (; at != last && is_digit(*at); ++at) {
    number = number * 10 + static_cast<std::uint64_t>(*at - '0');
  }
}

double power_of_two(int exponent) {
  return std::bit_cast<double>(static_cast<std::uint64_t>(1023 + exponent) << 52);
}

// mantissa · 10^scale, correctly rounded: the product or quotient with 5^|scale| to 62 bits or
// more, exactly but for a last bit that says whether anything follows; its conversion to double is
// the only rounding. Needs: mantissa > 0, |scale| <= kMostFives, which keeps far from the range's
// ends.
double scaled_by_ten(std::uint64_t mantissa, int scale) {
  const auto size = static_cast<std::size_t>(std::abs(scale));
  if (scale < 0) {
    const int up = std::countl_zero(mantissa);
    const int divisor_up = std::countl_zero(kPowersOfFive[size]);
    const std::uint64_t divisor = kPowersOfFive[size] << divisor_up;
    // Half the mantissa is less than the divisor, the whole at least half of it: 63 or 64 bits.
    const UInt128 dividend = static_cast<UInt128>(mantissa << up) << 63;
    const auto quotient = static_cast<std::uint64_t>(dividend / divisor);
    const bool more = static_cast<UInt128>(quotient) * divisor != dividend;
    return static_cast<double>(quotient | (more ? 1U : 0U)) *
           power_of_two(divisor_up - up - 63 + scale);
  }
  const UInt128 product = static_cast<UInt128>(mantissa) * kPowersOfFive[size];
  const auto high = static_cast<std::uint64_t>(product >> 64);
  if (high == 0)
    return static_cast<double>(static_cast<std::uint64_t>(product)) * power_of_two(scale);
  const int up = std::countl_zero(high);
  const UInt128 moved = product << up;
  const bool more = static_cast<std::uint64_t>(moved) != 0;
  return static_cast<double>(static_cast<std::uint64_t>(moved >> 64) | (more ? 1U : 0U)) *
         power_of_two(64 - up + scale);
}

// How many digits there are from the first that is not zero on.
std::ptrdiff_t significant_digits(const char* first, const char* last) {
  while (first != last && (*first == '0' || *first == '.')) ++first;
  std::ptrdiff_t count = 0;
  for (; first != last && (is_digit(*first) || *first == '.'); ++first) count += *first != '.';
  return count;
}

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

constexpr int kLargeScale = 100'000;  // of ten, past all that a double can hold

// The eight digits of a number below 10^8, each a byte of one word, the first digit lowest.
std::uint64_t eight_digits(std::uint64_t value) {
  std::uint64_t word = value / 10'000 | value % 10'000 << 32;
  // Fours to pairs to digits; (x · 5243) >> 19 is x / 100 below 10'000, (x · 103) >> 10 is x / 10
  // below 100.
  const std::uint64_t hundreds = (word * 5243 >> 19) & 0x0000007F0000007FU;
  word = hundreds | (word - hundreds * 100) << 16;
  const std::uint64_t tens = (word * 103 >> 10) & 0x000F000F000F000FU;
  return tens | (word - tens * 10) << 8;
}

constexpr std::uint64_t kZeros = 0x3030303030303030U;  // as characters

// digits · 10^scale with as few characters as can be, without an exponent where that takes no more.
// Needs: 0 < digits < 10^17; -31 < scale; where scale > 0, it is less than 8.
char* put_decimal(char* at, std::uint64_t digits, int scale) {
  // All 17 digits, and zeros behind them for what is copied beyond.
  std::array<char, 48> text;
  text.fill('0');
  const std::uint64_t low = eight_digits(digits % 100'000'000);
  const std::uint64_t above = digits / 100'000'000;
  const std::uint64_t middle = eight_digits(above % 100'000'000);
  text[0] = static_cast<char>('0' + above / 100'000'000);
  const std::uint64_t middle_text = middle | kZeros, low_text = low | kZeros;
  std::memcpy(text.data() + 1, &middle_text, 8);
  std::memcpy(text.data() + 9, &low_text, 8);
  const int leading = text[0] != '0' ? 0
                      : middle != 0  ? 1 + std::countr_zero(middle) / 8
                                     : 9 + std::countr_zero(low) / 8;
  const int trailing = low != 0      ? std::countl_zero(low) / 8
                       : middle != 0 ? 8 + std::countl_zero(middle) / 8
                                     : 16;
  const char* const first = text.data() + leading;
  const int count = 17 - leading - trailing;
  scale += trailing;
  const int power = scale + count - 1;  // of ten, of the first digit
  const int with_exponent = count + (count > 1 ? 1 : 0) + 4;
  const int plain = scale >= 0 ? count + scale : power >= 0 ? count + 1 : count + 1 - power;
  if (plain > with_exponent) {
    *at++ = *first;
    if (count > 1) {
      *at++ = '.';
      std::memcpy(at, first + 1, 16);
      at += count - 1;
    }
    *at++ = 'e';
    *at++ = power < 0 ? '-' : '+';
    *at++ = static_cast<char>('0' + std::abs(power) / 10);
    *at++ = static_cast<char>('0' + std::abs(power) % 10);
    return at;
  }
  if (power < 0) {  // at most three zeros behind the point: more take longer than an exponent
    std::memcpy(at, "0.000000", 8);
    std::memcpy(at + 1 - power, first, 17);
    return at + plain;
  }
  std::memcpy(at, first, 17);
  if (scale >= 0) return at + plain;
  char* const point = at + power + 1;
  *point = '.';
  std::memcpy(point + 1, first + power + 1, static_cast<std::size_t>(count - power - 1));
  return at + plain;
}

// digits · 10^-n of a value that most are like: written where it stays, the whole part by itself.
// Needs: `value`, 0.001 to 10^8, is what the digits read back as; they are 10^17 at most.
char* put_usual(char* at, double value, std::uint64_t digits, int n) {
  const auto whole = static_cast<std::uint64_t>(value);
  if (whole > 0) {
    // Then n is at most 16. Digits of more than the whole part are never those of the next number.
    digits -= whole * kWholePowersOfTen[static_cast<std::size_t>(n)];
    digits *= kWholePowersOfTen[static_cast<std::size_t>(16 - n)];
    at = put_integer(at, whole);
    if (digits == 0) return at;
    *at = '.';
    n = 16;
  } else {
    if (n < 16) digits *= kWholePowersOfTen[static_cast<std::size_t>(16 - std::exchange(n, 16))];
    // n is 16 to 20; what is more than 16 digits is one of them, behind zeros.
    std::memcpy(at, "0.000000", 8);
    const std::uint64_t top = digits / kWholePowersOfTen[16];
    digits -= top * kWholePowersOfTen[16];
    at[n - 15] = static_cast<char>('0' + top);
    at[1] = '.';
    ++at;
  }
  const std::uint64_t middle = eight_digits(digits / 100'000'000);
  const std::uint64_t low = eight_digits(digits % 100'000'000);
  const std::uint64_t middle_text = middle | kZeros, low_text = low | kZeros;
  at += n - 15;
  std::memcpy(at, &middle_text, 8);
  std::memcpy(at + 8, &low_text, 8);
  if (low != 0) return at + 16 - std::countl_zero(low) / 8;
  at += 8;
  if (middle != 0) return at - std::countl_zero(middle) / 8;
  // Nothing but the digit and the zeros before these: not many have so few.
  at -= 8;
  while (at[-1] == '0') --at;
  return at;
}

// The shortest decimal that reads back as `value`, and of those of that length the nearest. False,
// and nothing written, where the arithmetic below would need more than 128 bits, or the numbers
// next to `value` are not equally far.
// The value is c · 2^q, and all between (c ± 1/2) · 2^q read back as it. Scaled by the power of ten
// that makes this interval 1 to 10 wide, it holds some whole number and no more than one multiple
// of ten: that one, if there is one, has the shortest decimal, otherwise the nearest whole number.
// With 10^n = 5^n · 2^n, all of it are whole numbers over one power of two: nothing is rounded.
template <class Real>
bool put_nearest(char*& at, Real value) {
  using Bits = std::conditional_t<sizeof(Real) == 8, std::uint64_t, std::uint32_t>;
  constexpr int kFraction = std::numeric_limits<Real>::digits - 1;
  constexpr int kBias = std::numeric_limits<Real>::max_exponent - 1 + kFraction;
  const auto bits = std::bit_cast<Bits>(value);
  const std::uint64_t fraction = bits & ((Bits{1} << kFraction) - 1);
  const int q = static_cast<int>(bits >> kFraction) - kBias;
  if (q < -89 || q >= 0 || fraction == 0) return false;
  const std::uint64_t c = fraction | std::uint64_t{1} << kFraction;
  const int n = -((q * 315653) >> 20);  // the largest power of ten up to 2^q is 10^-n
  const std::uint64_t five = kPowersOfFive[static_cast<std::size_t>(n)];
  const UInt128 doubled = static_cast<UInt128>(2 * c) * five;  // half the interval: `five`
  const int shift = 1 - q - n;                                 // over 2^shift
  const auto whole = static_cast<std::uint64_t>(doubled >> shift);
  const auto rest = static_cast<std::uint64_t>(doubled - (static_cast<UInt128>(whole) << shift));
  const std::uint64_t ones = whole % 10;
  // The ends of the interval read back as the value where c is even: ties go to even.
  const UInt128 within = static_cast<UInt128>(five) + (c % 2 == 0 ? 1 : 0);
  const UInt128 down = (static_cast<UInt128>(ones) << shift) + rest;
  const UInt128 up = (static_cast<UInt128>(10) << shift) - down;
  const std::uint64_t half = std::uint64_t{1} << (shift - 1);
  // Chosen without a branch: it would be taken one way as often as the other.
  const std::uint64_t nearest = whole + (rest + (whole & 1) > half ? 1 : 0);
  const std::uint64_t ten = whole - ones + (down < within ? 0 : 10);
  const std::uint64_t digits = down < within || up < within ? ten : nearest;
  at = value >= Real(0.001) && value < Real(100'000)
           ? put_usual(at, static_cast<double>(value), digits, n)
           : put_decimal(at, digits, -n);
  return true;
}

template <class Real>
char* put_shortest(char* at, Real value) {
  assert(std::isfinite(value));
  if constexpr (std::endian::native == std::endian::little) {
    *at = '-';
    char* end = at + (value < 0 ? 1 : 0);
    if (put_nearest(end, std::abs(value))) return end;
  }
  // Adding zero turns -0 into 0 and changes nothing else.
  return std::to_chars(at, at + kMaxNumberText, value + Real{0}).ptr;
}

}  // namespace

char* put_number(char* at, double value) { return put_shortest(at, value); }
char* put_number(char* at, float value) { return put_shortest(at, value); }

char* put_integer(char* at, std::uint64_t value) {
  // Indices, most of what is written: eight digits at once, each a byte of one word.
  if (value < 100'000'000 && std::endian::native == std::endian::little) {
    std::uint64_t word = eight_digits(value);
    // The first digit that is not zero, or the last one.
    const int leading = word == 0 ? 7 : std::countr_zero(word) / 8;
    word = (word | kZeros) >> 8 * leading;
    std::memcpy(at, &word, 8);
    return at + (8 - leading);
  }
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

  std::uint64_t mantissa = 0;
  read_digits(at, last, mantissa);
  std::ptrdiff_t all_digits = at - unsigned_start;
  int scale = 0;
  if (at != last && *at == '.') {
    const char* const fraction = ++at;
    read_digits(at, last, mantissa);
    all_digits += at - fraction;
    scale = -static_cast<int>(std::min<std::ptrdiff_t>(at - fraction, kLargeScale));
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
        if (exponent < kLargeScale) exponent = exponent * 10 + (*power - '0');
      }
      scale += power_negative ? -exponent : exponent;
      at = power;
    }
  }
  // 19 digits fit in 64 bits. With a mantissa below 2^53 and a small power of ten, nearly all
  // numbers there are, one operation rounds correctly (Clinger 1990).
  if (scale >= -kMostFives && scale <= kMostFives &&
      (all_digits <= 19 || significant_digits(unsigned_start, at) <= 19)) {
    double size = 0;
    if (mantissa <= (std::uint64_t{1} << 53) && scale >= -22 && scale <= 22) {
      const double whole = static_cast<double>(mantissa);
      size = scale < 0 ? whole / kPowersOfTen[static_cast<std::size_t>(-scale)]
                       : whole * kPowersOfTen[static_cast<std::size_t>(scale)];
    } else if (mantissa > 0) {
      size = scaled_by_ten(mantissa, scale);
    }
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
  // Up to 18 digits cannot overflow.
  if (!word.empty() && word.size() <= 18) {
    const bool negative = word.front() == '-';
    if (negative) word.remove_prefix(1);
    for (const char c : word) {
      if (!is_digit(c)) return std::nullopt;
      value = value * 10 + (c - '0');
    }
    if (word.empty()) return std::nullopt;
    return negative ? -value : value;
  }
  const char* const end = word.data() + word.size();
  const std::from_chars_result read = std::from_chars(word.data(), end, value);
  if (word.empty() || read.ec != std::errc{} || read.ptr != end) return std::nullopt;
  return value;
}

}  // namespace diesink
