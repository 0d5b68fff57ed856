// SPDX-License-Identifier: Apache-2.0
#include "core/part_program/statement.h"

#include <algorithm>

namespace diesink {
namespace {

constexpr std::string_view kBlanks = " \t";

// Start and length of `text` without blanks around it.
std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return text.substr(0, 0);
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

Statement statement_of(std::string_view line, std::string_view body, std::uint32_t number) {
  Statement statement;
  const auto column = [line](std::string_view part) {
    return static_cast<std::uint32_t>(part.data() - line.data() + 1);
  };
  statement.line = number;
  statement.line_text = line;
  statement.body = body;
  statement.column = column(body);
  while (true) {
    const std::size_t comma = body.find(',');
    const std::string_view field = trimmed(body.substr(0, comma));
    if (statement.fields.size() < Statement::kMaxFields) {
      statement.fields.push_back({field, column(field)});
    }
    ++statement.field_count;
    if (comma == std::string_view::npos) return statement;
    body.remove_prefix(comma + 1);
  }
}

}  // namespace

Statements split_statements(std::string_view text) {
  Statements statements;
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  std::uint32_t number = 0;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    ++number;
    statements.last_line = number;
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (line.size() > kMaxLineBytes) {
      statements.fault = LexFault::kLineTooLong;
      return statements;
    }
    const std::size_t comment = std::min(line.find('#'), line.find("$$"));
    const std::string_view body = trimmed(line.substr(0, comment));
    if (body.empty()) continue;
    if (statements.list.size() == kMaxStatements) {
      statements.fault = LexFault::kTooManyStatements;
      return statements;
    }
    statements.list.push_back(statement_of(line, body, number));
  }
  return statements;
}

std::string upper_case(std::string_view text) {
  std::string upper(text);
  for (char& c : upper) {
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  }
  return upper;
}

}  // namespace diesink
