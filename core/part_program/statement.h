// The text of a part program as statements with columns.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/diagnostics.h"

namespace diesink {

// Limits of a part program.
inline constexpr std::size_t kMaxProgramBytes = 16u << 20;
inline constexpr std::size_t kMaxLineBytes = 1u << 20;
inline constexpr std::size_t kMaxStatements = 100'000;
inline constexpr std::size_t kMaxNesting = 64;
inline constexpr double kMaxCoordinate = 1e9;
inline constexpr double kMaxGridPoints = 100e6;

struct Field {
  std::string_view text;     // without blanks around it
  std::uint32_t column = 1;  // of its first byte, from 1
};

// One line that is not blank: views into the program's text.
struct Statement {
  std::uint32_t line = 0;       // from 1
  std::string_view line_text;   // the whole line, without its end
  std::string_view body;        // without comment, without blanks around it
  std::uint32_t column = 1;     // of the body's first byte
  std::vector<Field> fields;    // the first kMaxFields of them
  std::size_t field_count = 0;  // of all

  static constexpr std::size_t kMaxFields = 16;  // more than any statement takes
};

// Why lexing stopped before the end of the text.
enum class LexFault : std::uint8_t { kNone, kLineTooLong, kTooManyStatements };

struct Statements {
  std::vector<Statement> list;
  std::uint32_t last_line = 1;  // the last line read
  LexFault fault = LexFault::kNone;
};

// Lines end in LF or CRLF; `$$` and `#` begin a comment; a UTF-8 byte order mark is skipped (and
// not counted in columns). Errors: a line over kMaxLineBytes or more than kMaxStatements end the
// list and set `fault`.
Statements split_statements(std::string_view text);

// Letters in upper case; other bytes as they are.
std::string upper_case(std::string_view text);

}  // namespace diesink
