// A value or an error: the way bad data leaves core and formats (never by exception).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cassert>
#include <cstdint>
#include <string>
#include <utility>
#include <variant>

namespace diesink {

// What kind of failure; the command line turns it into its exit status.
enum class ErrorCode : std::uint8_t {
  kUsage,        // exit 1: wrong command or option
  kInput,        // exit 2: a file or value that is wrong
  kUnsupported,  // exit 3: not in this build
  kOutput,       // exit 4: an output could not be written
  kLimit,        // exit 2: an input larger than the limits allow
};

// Where in which file. Zero line means "no line"; byte < 0 means "no byte offset".
struct Place {
  std::string file;
  std::uint32_t line = 0;    // from 1
  std::uint32_t column = 0;  // from 1, in bytes of the line
  std::int64_t byte = -1;    // offset in a binary file
};

// What was found and what was expected, in one sentence without the place.
struct Error {
  ErrorCode code = ErrorCode::kInput;
  std::string message;
  Place where;
};

// `FILE:LINE:COLUMN: error: message` or `FILE:@BYTE: error: message`.
std::string to_text(const Error& error);

// Holds a T or an Error. Named after std::expected so that it can be swapped for it later.
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}      // NOLINT: implicit on purpose
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}  // NOLINT: implicit on purpose

  [[nodiscard]] bool has_value() const { return state_.index() == 0; }
  explicit operator bool() const { return has_value(); }

  // Needs: has_value().
  [[nodiscard]] T& value() { return assert(has_value()), *std::get_if<0>(&state_); }
  [[nodiscard]] const T& value() const { return assert(has_value()), *std::get_if<0>(&state_); }
  T& operator*() { return value(); }
  const T& operator*() const { return value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }

  // Needs: !has_value().
  [[nodiscard]] Error& error() { return assert(!has_value()), *std::get_if<1>(&state_); }
  [[nodiscard]] const Error& error() const { return assert(!has_value()), *std::get_if<1>(&state_); }

 private:
  std::variant<T, Error> state_;
};

struct Nothing {};
using Status = Result<Nothing>;
inline Status ok() { return Nothing{}; }

}  // namespace diesink
