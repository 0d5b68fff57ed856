// SPDX-License-Identifier: Apache-2.0
#include "formats/text_scanner.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "core/counted.h"

namespace diesink {
namespace {

// The first byte that is one of the three, or `last`: eight bytes at a time.
template <char kA, char kB, char kC>
const char* find_any_of(const char* at, const char* last) {
  constexpr std::uint64_t kOnes = 0x0101010101010101U, kTops = 0x8080808080808080U;
  const auto zeros = [](std::uint64_t word, char c) {
    word ^= kOnes * static_cast<unsigned char>(c);
    // The top bit of each byte that is zero; above the first of them others may carry it, too.
    return (word - kOnes) & ~word & kTops;
  };
  if constexpr (std::endian::native == std::endian::little) {
    for (; last - at >= 8; at += 8) {
      std::uint64_t word = 0;
      std::memcpy(&word, at, 8);
      const std::uint64_t found = zeros(word, kA) | zeros(word, kB) | zeros(word, kC);
      if (found != 0) return at + std::countr_zero(found) / 8;
    }
  }
  while (at != last && *at != kA && *at != kB && *at != kC) ++at;
  return at;
}

}  // namespace

std::string_view text_of(std::span<const std::byte> bytes) {
  // The standard lets any object be looked at as char.
  std::string_view text(static_cast<const char*>(static_cast<const void*>(bytes.data())),
                        bytes.size());
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  return text;
}

std::string first_word_of(std::span<const std::byte> bytes) {
  const std::string_view text = text_of(bytes);
  std::size_t at = 0;
  while (at < text.size() && (is_blank(text[at]) || is_line_end(text[at]) || text[at] == '#')) {
    if (text[at] == '#') {
      while (at < text.size() && !is_line_end(text[at])) ++at;
    } else {
      ++at;
    }
  }
  std::string word;
  for (; at < text.size() && word.size() < 15 && !is_blank(text[at]) && !is_line_end(text[at]);
       ++at) {
    const char c = text[at];
    if (c < 0x21 || c > 0x7E) return {};
    word += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  }
  return word;
}

bool TextScanner::skip_continuation() {
  const char* next = at_ + 1;
  if (next == end_ || !is_line_end(*next)) return false;
  at_ = next + (*next == '\r' && next + 1 != end_ && next[1] == '\n' ? 2 : 1);
  return true;
}

std::string_view TextScanner::rest_of_line() {
  if (!more_in_line()) return {at_, 0};
  const char* const first = at_;
  while (at_ != end_ && !is_line_end(*at_)) ++at_;
  const char* last = at_;
  while (is_blank(last[-1])) --last;
  return {first, static_cast<std::size_t>(last - first)};
}

void TextScanner::skip_line(bool comment) {
  const bool continued = continuation_ && !comment;
  while (at_ != end_) {
    at_ = continued ? find_any_of<'\n', '\r', '\\'>(at_, end_)
                    : find_any_of<'\n', '\r', '\n'>(at_, end_);
    if (at_ == end_) return;
    if (*at_ == '\\' && continued && skip_continuation()) continue;
    const char c = *at_++;
    if (!is_line_end(c)) continue;
    if (c == '\r' && at_ != end_ && *at_ == '\n') ++at_;
    return;
  }
}

bool TextScanner::has_lone_cr() const {
  const char* const first = std::find_if(begin_, end_, is_line_end);
  return first != end_ && *first == '\r' && (first + 1 == end_ || first[1] != '\n');
}

Place TextScanner::place(const char* at) const {
  Place place{file_, 1, 1, -1};
  const char* line = begin_;
  while (true) {
    const char* const ends = find_any_of<'\n', '\r', '\n'>(line, at);
    if (ends == at) break;
    // A CR and its LF end one line, also where `at` is between them.
    const bool pair = *ends == '\r' && ends + 1 != end_ && ends[1] == '\n';
    if (pair && ends + 1 == at) break;
    ++place.line;
    line = ends + (pair ? 2 : 1);
  }
  place.column = static_cast<std::uint32_t>(std::min<std::ptrdiff_t>(at - line, 0xFFFFFFF)) + 1;
  return place;
}

Error TextScanner::error(std::string message, const char* at) const {
  return {ErrorCode::kInput, std::move(message), place(at == nullptr ? at_ : at)};
}

Error TextScanner::number_error(NumberState state, std::string_view expected) const {
  TextScanner ahead = *this;
  const std::string_view word = ahead.word();
  std::string message;
  if (word.empty()) {
    message = ahead.at_end() ? "the file ends" : "the line ends";
  } else if (state == NumberState::kTooLarge) {
    message = quoted(word) + " is larger than any number";
  } else if (state == NumberState::kNotFinite) {
    message = quoted(word) + " is no finite number";
  } else {
    message = quoted(word) + " is not a number";
    if (word.find(',') != std::string_view::npos) message += " (decimals need a point)";
  }
  message += ", expected ";
  message += expected;
  return error(std::move(message), ahead.at() - word.size());
}

void Tally::warn(std::string_view words, const TextScanner& text, Diagnostics& diagnostics) const {
  if (count_ == 0) return;
  diagnostics.warning(counted(count_, words), text.place(first_));
}

}  // namespace diesink
