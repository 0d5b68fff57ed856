// Lines and words of a text file in memory, with places for messages.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "core/diagnostics.h"
#include "core/result.h"

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

}  // namespace diesink
