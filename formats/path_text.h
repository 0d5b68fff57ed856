// What the path readers share: lines with places, errors up to a limit, numbers within limits.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <string>
#include <string_view>

#include "core/diagnostics.h"
#include "formats/text_number.h"
#include "formats/text_scanner.h"

namespace diesink {

inline constexpr std::size_t kMostPathErrors = 20;
inline constexpr double kLargestPathNumber = 1e9;

// Walks over the lines of a text; LF and CRLF end one.
class PathLines {
 public:
  PathLines(std::string_view text, std::string file_name, Diagnostics& diagnostics)
      : text_(text), file_(std::move(file_name)), diagnostics_(diagnostics) {}

  // The next line; false at the end, or once there are too many errors.
  bool next() {
    if (text_.empty() || diagnostics_.error_count() >= kMostPathErrors) return false;
    const std::size_t end = text_.find('\n');
    line_ = text_.substr(0, end);
    text_.remove_prefix(end == std::string_view::npos ? text_.size() : end + 1);
    if (!line_.empty() && line_.back() == '\r') line_.remove_suffix(1);
    ++number_;
    if (line_.size() > kMaxLineBytes) {
      const std::size_t size = line_.size();
      line_ = {};
      error(1, "a line of " + std::to_string(size) + " bytes; expected at most 1 MiB");
    }
    return true;
  }
  [[nodiscard]] std::string_view line() const { return line_; }
  [[nodiscard]] Place place(std::size_t column) const {
    return {file_, number_, static_cast<std::uint32_t>(column)};
  }
  // column from 1.
  void error(std::size_t column, std::string message) {
    diagnostics_.error(std::move(message), place(column), std::string(line_.substr(0, 200)));
  }
  void warning(std::size_t column, std::string message) {
    diagnostics_.warning(std::move(message), place(column), std::string(line_.substr(0, 200)));
  }
  // The number that is the whole word; false after an error.
  bool number(std::string_view word, std::size_t column, double& value) {
    std::optional<double> read;
    if (word.size() <= 64) read = number_of(word);
    if (!read || !std::isfinite(*read)) {
      error(column, "'" + std::string(word.substr(0, 40)) + "' is not a number");
      return false;
    }
    if (std::fabs(*read) > kLargestPathNumber) {
      error(column, "'" + std::string(word.substr(0, 40)) + "' is too large; expected at most 1e9");
      return false;
    }
    value = *read;
    return true;
  }

 private:
  std::string_view text_, line_;
  std::string file_;
  Diagnostics& diagnostics_;
  std::uint32_t number_ = 0;
};

inline std::string upper_case(std::string_view text) {
  std::string upper(text);
  for (char& c : upper) {
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  }
  return upper;
}

inline std::string_view without_blanks(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

}  // namespace diesink
