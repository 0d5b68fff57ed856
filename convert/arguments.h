// Options of the command line, read strictly: whole numbers and lengths that never depend on the
// locale. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace diesink {

// What a number must lie in.
struct NumberRange {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool open_low = false;  // `low` itself is refused
};
inline constexpr NumberRange kAnyNumber{};
inline constexpr NumberRange kPositive{0, std::numeric_limits<double>::infinity(), true};
inline constexpr NumberRange kNotNegative{0, std::numeric_limits<double>::infinity(), false};

// Each adds an option whose value is checked while the command line is read; a wrong one is wrong
// usage, told with what was found and what was expected. `names` is CLI11's: "-o,--output" or
// "--tolerance".
CLI::Option* add_number(CLI::App& app, const std::string& names, std::optional<double>& value,
                        const std::string& summary, NumberRange range = kAnyNumber);
CLI::Option* add_whole_number(CLI::App& app, const std::string& names, std::optional<int>& value,
                              const std::string& summary, int low, int high);
// `--cutter D,R`: diameter above 0, corner radius from 0 to half of it.
CLI::Option* add_cutter(CLI::App& app, std::optional<std::array<double, 2>>& value,
                        const std::string& summary);
// `NXxNY`, both at least 1
CLI::Option* add_size(CLI::App& app, const std::string& names, std::array<int, 2>& value,
                      const std::string& shape, const std::string& summary, int high);
// `--name` or `--name=NUMBER`; the number may be left out.
CLI::Option* add_flag_with_number(CLI::App& app, const std::string& name, bool& given,
                                  std::optional<double>& value, const std::string& summary,
                                  NumberRange range = kAnyNumber);

struct Choice {
  std::string_view name;
  int value;
};
CLI::Option* add_choice_function(CLI::App& app, const std::string& names,
                                 std::span<const Choice> choices, const std::string& summary,
                                 std::function<void(int)> chosen);

template <class Enumeration>
struct Chosen {
  using Type = Enumeration;
};
template <class Enumeration>
struct Chosen<std::optional<Enumeration>> {
  using Type = Enumeration;
};

// One word of `choices`, whose values are those of the enumeration; `value` keeps its default where
// the option is not given.
// Needs: `choices` outlives the command line's reading.
// `Value` is the enumeration, or an optional of it.
template <class Value>
CLI::Option* add_choice(CLI::App& app, const std::string& names, Value& value,
                        std::span<const Choice> choices, const std::string& summary) {
  return add_choice_function(app, names, choices, summary, [&value](int chosen) {
    value = static_cast<typename Chosen<Value>::Type>(chosen);
  });
}

}  // namespace diesink
