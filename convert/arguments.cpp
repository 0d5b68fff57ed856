// Strict readers for option values: CLI11 2.1.2 on its own takes `nan` and `inf` and reads `010` as
// octal.
// SPDX-License-Identifier: Apache-2.0
#include "convert/arguments.h"

#include <CLI/App.hpp>
#include <cmath>
#include <vector>

#include "core/nearest.h"
#include "formats/text_number.h"

namespace diesink {
namespace {

constexpr double kLargestNumber = 1e9;  // as in statements and in files

[[noreturn]] void refuse(const std::string& names, const std::string& message) {
  if (names.empty()) throw CLI::ValidationError(message);
  // The option as people type it: the long name where there is one.
  const std::size_t comma = names.rfind(',');
  throw CLI::ValidationError(comma == std::string::npos ? names : names.substr(comma + 1), message);
}

std::string expectation(const NumberRange& range) {
  std::string text = "a number";
  if (std::isfinite(range.low))
    text += (range.open_low ? " above " : " of at least ") + to_text(range.low);
  if (std::isfinite(range.high)) text += " and at most " + to_text(range.high);
  return text;
}

// Decimal digits only: `010` is ten, a sign is refused.
std::optional<int> whole_number_of(std::string_view text) {
  if (text.empty() || text.find_first_not_of("0123456789") != text.npos) return std::nullopt;
  const std::optional<std::int64_t> number = integer_of(text);
  if (!number || *number > std::numeric_limits<int>::max()) return std::nullopt;
  return static_cast<int>(*number);
}

double checked(const std::string& names, std::string_view text, const NumberRange& range) {
  const std::optional<double> number = number_of(text);
  if (!number || *number < range.low || *number > range.high ||
      (range.open_low && *number <= range.low)) {
    refuse(names, "'" + std::string(text) + "' is not " + expectation(range));
  }
  if (std::fabs(*number) > kLargestNumber) {
    refuse(names, "'" + std::string(text) + "' is beyond the limit of 1e9");
  }
  return *number;
}

}  // namespace

CLI::Option* add_number(CLI::App& app, const std::string& names, std::optional<double>& value,
                        const std::string& summary, NumberRange range) {
  return app
      .add_option_function<std::string>(
          names,
          [names, range, &value](const std::string& text) { value = checked(names, text, range); },
          summary)
      ->type_name("NUMBER");
}

CLI::Option* add_whole_number(CLI::App& app, const std::string& names, std::optional<int>& value,
                              const std::string& summary, int low, int high) {
  return app
      .add_option_function<std::string>(
          names,
          [names, low, high, &value](const std::string& text) {
            value = whole_number_of(text);
            if (!value || *value < low || *value > high) {
              refuse(names, "'" + text + "' is not a whole number from " + std::to_string(low) +
                                " to " + std::to_string(high));
            }
          },
          summary)
      ->type_name("N");
}

CLI::Option* add_cutter(CLI::App& app, std::optional<std::array<double, 2>>& value,
                        const std::string& summary) {
  const std::string name = "--cutter";
  return app
      .add_option_function<std::string>(
          name,
          [name, &value](const std::string& text) {
            const std::size_t comma = text.find(',');
            if (comma == std::string::npos) refuse(name, "'" + text + "' is not two numbers D,R");
            const std::string_view both = text;
            const double diameter = checked(name, both.substr(0, comma), kPositive);
            const double corner = checked(name, both.substr(comma + 1), kNotNegative);
            if (corner > diameter / 2) {
              refuse(name, "'" + text + "' has a corner radius above half its diameter, " +
                               to_text(diameter / 2));
            }
            value = {diameter, corner};
          },
          summary)
      ->type_name("D,R");
}

CLI::Option* add_size(CLI::App& app, const std::string& names, std::array<int, 2>& value,
                      const std::string& shape, const std::string& summary, int high) {
  return app
      .add_option_function<std::string>(
          names,
          [names, shape, high, &value](const std::string& text) {
            const std::size_t cross = text.find_first_of("xX");
            const std::string_view both = text;
            std::optional<int> first, second;
            if (cross != std::string::npos) {
              first = whole_number_of(both.substr(0, cross));
              second = whole_number_of(both.substr(cross + 1));
            }
            if (!first || !second || *first < 1 || *second < 1 || *first > high || *second > high) {
              refuse(names, "'" + text + "' is not two whole numbers " + shape + " from 1 to " +
                                std::to_string(high));
            }
            value = {*first, *second};
          },
          summary)
      ->type_name(shape);
}

CLI::Option* add_flag_with_number(CLI::App& app, const std::string& name, bool& given,
                                  std::optional<double>& value, const std::string& summary,
                                  NumberRange range) {
  // A flag takes its value only after '=', so the word that follows `--solid` stays a file name.
  return app.add_flag(name, summary)->each([name, range, &given, &value](const std::string& text) {
    given = true;
    if (text != "true") value = checked("", text, range);  // CLI11 puts a flag's name before it
  });
}

CLI::Option* add_choice_function(CLI::App& app, const std::string& names,
                                 std::span<const Choice> choices, const std::string& summary,
                                 std::function<void(int)> chosen) {
  std::string shape;
  std::vector<std::string_view> words;
  for (const Choice& each : choices) {
    shape += (shape.empty() ? "" : "|") + std::string(each.name);
    words.push_back(each.name);
  }
  return app
      .add_option_function<std::string>(
          names,
          [names, shape, words, choices, chosen = std::move(chosen)](const std::string& text) {
            for (const Choice& each : choices) {
              if (each.name == text) return chosen(each.value);
            }
            const std::optional<std::size_t> near = nearest_word(text, words);
            refuse(names, "'" + text + "' is not one of " + shape +
                              (near ? "; did you mean '" + std::string(words[*near]) + "'?" : ""));
          },
          summary)
      ->type_name(shape);
}

}  // namespace diesink
