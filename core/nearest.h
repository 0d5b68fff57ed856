// The known word a wrong one was probably meant to be.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string_view>

namespace diesink {

// The index of the word of `known` with the fewest edits to `word` (insert, delete, replace, swap
// of neighbours; upper and lower case are the same); the first of equals. Empty where the nearest
// is further than a third of the longer word's length, at least one edit.
std::optional<std::size_t> nearest_word(std::string_view word,
                                        std::span<const std::string_view> known);

}  // namespace diesink
