// What the section readers share: numbers of statements, and words of messages.
// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "core/nearest.h"
#include "core/number.h"
#include "core/part_program/sections.h"

namespace diesink {

bool read_field(const Statement& statement, std::size_t index, double& value, Report& report) {
  const Field& field = statement.fields[index];
  if (field.text.empty()) {
    report.error(statement, field, "a number is missing here");
    return false;
  }
  switch (read_number(field.text, value)) {
    case NumberFault::kNone:
      return true;
    case NumberFault::kNotANumber:
      report.error(statement, field, quoted(field.text) + " is not a number");
      return false;
    case NumberFault::kNotFinite:
      report.error(statement, field, quoted(field.text) + " is not a finite number");
      return false;
    case NumberFault::kTooLarge:
      report.error(statement, field, quoted(field.text) + " is too large for a number");
      return false;
  }
  return false;
}

bool read_numbers(const Statement& statement, std::size_t first, std::size_t count,
                  bool coordinates, std::string_view what, double* out, Report& report) {
  if (statement.field_count != first + count) {
    report.error(statement, statement.column,
                 std::string(what) + " takes " + std::to_string(count) +
                     (count == 1 ? " number" : " numbers") + " (got " +
                     std::to_string(statement.field_count - first) + ')');
    return false;
  }
  bool good = true;
  for (std::size_t k = 0; k < count; ++k) {
    double value = 0;
    if (!read_field(statement, first + k, value, report)) {
      good = false;
    } else if (coordinates && std::fabs(value) > kMaxCoordinate) {
      report.error(statement, statement.fields[first + k],
                   number_text(value) + " is beyond the limit of 1e9");
      good = false;
    }
    out[k] = value;
  }
  return good;
}

bool read_count(const Statement& statement, std::size_t index, int least, int most,
                std::string_view what, int& value, Report& report) {
  double number = 0;
  if (!read_field(statement, index, number, report)) return false;
  if (number != std::floor(number) || number < least || number > most) {
    report.error(statement, statement.fields[index],
                 std::string(what) + " (got " +
                     std::string(statement.fields[index].text.substr(0, 40)) + ')');
    return false;
  }
  value = static_cast<int>(number);
  return true;
}

std::optional<std::size_t> meant_word(std::string_view word,
                                      const std::vector<std::string_view>& known) {
  if (const std::optional<std::size_t> nearest = nearest_word(word, known)) return nearest;
  constexpr std::size_t kFewest = 3;  // letters that tell one keyword from another
  std::optional<std::size_t> longest;
  for (std::size_t k = 0; k < known.size(); ++k) {
    if (known[k].size() >= kFewest && word.starts_with(known[k]) &&
        (!longest || known[k].size() > known[*longest].size())) {
      longest = k;
    }
  }
  return longest;
}

std::string suggestion(std::string_view word, const std::vector<std::string_view>& known) {
  if (word.size() < 2) return {};  // one letter may be meant for any other
  const std::optional<std::size_t> nearest = meant_word(word, known);
  return nearest ? "; did you mean " + std::string(known[*nearest]) + '?' : std::string();
}

std::string word_list(const std::vector<std::string_view>& words, std::string_view last) {
  std::string text;
  for (std::size_t k = 0; k < words.size(); ++k) {
    if (k > 0) text += k + 1 == words.size() ? ' ' + std::string(last) + ' ' : std::string(", ");
    text += words[k];
  }
  return text;
}

}  // namespace diesink
