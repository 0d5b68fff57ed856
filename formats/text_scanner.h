// Words and lines of a text file in memory, with places for messages.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "core/diagnostics.h"
#include "core/result.h"
#include "formats/text_number.h"

namespace diesink {

// A line longer than this is an error: no mesh file needs one, and it would bring its whole file
// into a message.
inline constexpr std::size_t kMaxLineBytes = std::size_t{1} << 20;

inline bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }
inline bool is_line_end(char c) { return c == '\n' || c == '\r'; }

// The bytes as characters, without a UTF-8 byte order mark.
std::string_view text_of(std::span<const std::byte> bytes);

// The first word that is not in a '#' comment, in lower case, at most 15 characters of it; empty
// where there is none or it holds a byte that is no printable ASCII.
std::string first_word_of(std::span<const std::byte> bytes);

// Walks over a text. LF, CRLF and CR end a line, in any mixture. Lines are counted only when a
// place is asked for.
class TextScanner {
 public:
  // `text` must outlive this; `continuation`: a backslash before a line's end makes it a blank.
  TextScanner(std::string_view text, std::string file_name, bool continuation = false)
      : begin_(text.data()),
        at_(text.data()),
        end_(text.data() + text.size()),
        file_(std::move(file_name)),
        continuation_(continuation) {}

  // The part from `first` to `last` alone, with places counted in the whole text.
  [[nodiscard]] TextScanner section(const char* first, const char* last) const {
    TextScanner part = *this;
    part.at_ = first;
    part.end_ = last;
    return part;
  }

  [[nodiscard]] bool at_end() const { return at_ == end_; }
  [[nodiscard]] const char* begin() const { return begin_; }
  [[nodiscard]] const char* at() const { return at_; }
  [[nodiscard]] const char* end() const { return end_; }
  [[nodiscard]] std::size_t left() const { return static_cast<std::size_t>(end_ - at_); }
  void move_to(const char* at) { at_ = at; }

  // Skips blanks; true where something of the line is left.
  bool more_in_line() {
    while (at_ != end_) {
      if (is_blank(*at_)) {
        ++at_;
      } else if (*at_ == '\\' && continuation_ && skip_continuation()) {
        continue;
      } else {
        return !is_line_end(*at_);
      }
    }
    return false;
  }

  // Skips blanks and line ends; true where something is left.
  bool more() {
    while (more_in_line(), at_ != end_ && is_line_end(*at_)) ++at_;
    return at_ != end_;
  }

  // The word at the cursor, empty (but in place) at a line's end.
  std::string_view word() {
    if (!more_in_line()) return {at_, 0};
    const char* const first = at_;
    while (at_ != end_ && !is_blank(*at_) && !is_line_end(*at_)) ++at_;
    return {first, static_cast<std::size_t>(at_ - first)};
  }

  // The rest of the line without blanks at both ends; the cursor goes to the line's end.
  std::string_view rest_of_line();

  // Goes behind the next line end. A line's end that a backslash continues is no end, except in a
  // comment.
  void skip_line(bool comment = false);

  // Reads a number that ends at a blank or line end. Without one the cursor stays before the word.
  NumberState number(double& value) {
    if (!more_in_line()) return NumberState::kNotANumber;
    const NumberAt read = read_number(at_, end_, value);
    if (read.state != NumberState::kOk) return read.state;
    if (read.end != end_ && !is_blank(*read.end) && !is_line_end(*read.end) && *read.end != '\\') {
      return NumberState::kNotANumber;
    }
    at_ = read.end;
    return NumberState::kOk;
  }

  // Reads a number of up to 18 digits and nothing else that ends at a blank or line end; else the
  // cursor stays where it is.
  bool digits(std::uint64_t& value) {
    std::uint64_t read = 0;
    const char* at = at_;
    for (; at != end_ && static_cast<unsigned char>(*at - '0') < 10; ++at) {
      read = read * 10 + static_cast<std::uint64_t>(*at - '0');
    }
    if (at == at_ || at - at_ > 18) return false;
    if (at != end_ && !is_blank(*at) && !is_line_end(*at)) return false;
    value = read;
    at_ = at;
    return true;
  }

  // Whether the first line end of the text is a CR without LF.
  [[nodiscard]] bool has_lone_cr() const;

  [[nodiscard]] Place place(const char* at) const;
  [[nodiscard]] Place place() const { return place(at_); }
  // An error at `at`, by default the cursor.
  [[nodiscard]] Error error(std::string message, const char* at = nullptr) const;
  // What went wrong with the number at the cursor: "'x' is not a number", "1e999 is too large", ...
  [[nodiscard]] Error number_error(NumberState state, std::string_view expected) const;

 private:
  bool skip_continuation();

  const char* begin_;
  const char* at_;
  const char* end_;
  std::string file_;
  bool continuation_;
};

// How often something odd was met, and where first.
class Tally {
 public:
  void hit(const char* at) {
    if (count_++ == 0) first_ = at;
  }
  void add(const Tally& later) {
    if (count_ == 0) first_ = later.first_;
    count_ += later.count_;
  }
  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] const char* first() const { return first_; }
  // Says it as a warning at the first place, where it was met at all; the words of counted().
  void warn(std::string_view words, const TextScanner& text, Diagnostics& diagnostics) const;

 private:
  std::size_t count_ = 0;
  const char* first_ = nullptr;
};

}  // namespace diesink
