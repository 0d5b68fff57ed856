// What the path readers share: lines with places, errors up to a limit, numbers within limits.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/diagnostics.h"
#include "core/tool_path.h"
#include "formats/text_number.h"
#include "formats/text_scanner.h"
#include "formats/text_source.h"

namespace diesink {

inline constexpr std::size_t kMostPathErrors = 20;
inline constexpr double kLargestPathNumber = 1e9;

// Walks over the lines of a text; LF and CRLF end one.
class PathLines {
 public:
  // Needs: `source` outlives it.
  PathLines(TextSource& source, std::string file_name, Diagnostics& diagnostics)
      : source_(source), file_(std::move(file_name)), diagnostics_(diagnostics) {}

  // The next line; false at the end, or once there are too many errors.
  bool next() {
    if (diagnostics_.error_count() >= kMostPathErrors) return false;
    if (text_.empty() && !more()) return false;
    std::size_t end = text_.find('\n');
    if (end != std::string_view::npos) {
      line_ = text_.substr(0, end);
      text_.remove_prefix(end + 1);
    } else {
      // The line goes on in the next block.
      whole_.assign(text_);
      while (more()) {
        end = text_.find('\n');
        if (whole_.size() <= kMaxLineBytes) whole_.append(text_.substr(0, end));
        if (end != std::string_view::npos) break;
      }
      if (text_.empty()) end = std::string_view::npos;
      text_.remove_prefix(end == std::string_view::npos ? text_.size() : end + 1);
      line_ = whole_;
    }
    if (!line_.empty() && line_.back() == '\r') line_.remove_suffix(1);
    ++number_;
    if (line_.size() > kMaxLineBytes) {
      const std::size_t size = line_.size();
      line_ = {};
      error(1, "a line of " + std::to_string(size) + " bytes or more; expected at most 1 MiB");
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
  void error(const Place& place, std::string message) {
    diagnostics_.error(std::move(message), place, {});
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
  bool more() {
    text_ = source_.next();
    if (number_ == 0 && whole_.empty()) text_ = text_of(std::as_bytes(std::span(text_)));
    return !text_.empty();
  }

  TextSource& source_;
  std::string_view text_, line_;
  std::string whole_, file_;
  Diagnostics& diagnostics_;
  std::uint32_t number_ = 0;
};

// Where a reader puts points: handed on some at a time.
class PointsRead {
 public:
  explicit PointsRead(const PathTaker& take) : take_(take) {}
  void add(const Vec3& tip, Motion motion) {
    waiting_.push_back({tip, motion});
    last_ = tip;
    ++count_;
    if (waiting_.size() == kPointsATime) hand_on();
  }
  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] const Vec3& last() const { return last_; }
  void hand_on() {
    if (!waiting_.empty()) take_(waiting_);
    waiting_.clear();
  }

 private:
  static constexpr std::size_t kPointsATime = 4096;
  const PathTaker& take_;
  std::vector<ClPoint> waiting_;
  std::size_t count_ = 0;
  Vec3 last_ = Vec3::Zero();
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
