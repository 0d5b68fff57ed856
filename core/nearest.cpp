// Damerau's edit distance in its optimal-string-alignment form.
// SPDX-License-Identifier: Apache-2.0
#include "core/nearest.h"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace diesink {
namespace {

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

std::size_t edits_between(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1), above(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) above[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const bool same = lower(a[i - 1]) == lower(b[j - 1]);
      row[j] = std::min({above[j] + 1, row[j - 1] + 1, above[j - 1] + (same ? 0u : 1u)});
      if (i > 1 && j > 1 && lower(a[i - 1]) == lower(b[j - 2]) &&
          lower(a[i - 2]) == lower(b[j - 1])) {
        row[j] = std::min(row[j], before[j - 2] + 1);
      }
    }
    before.swap(above);
    above.swap(row);
  }
  return above[b.size()];
}

}  // namespace

std::optional<std::size_t> nearest_word(std::string_view word,
                                        std::span<const std::string_view> known) {
  constexpr std::size_t kLongest =
      64;  // nobody mistypes a keyword into more; keeps hostile input cheap
  if (word.empty() || word.size() > kLongest) return std::nullopt;
  std::optional<std::size_t> best;
  std::size_t least = 0;
  for (std::size_t i = 0; i < known.size(); ++i) {
    const std::size_t edits = edits_between(word, known[i]);
    const std::size_t allowed =
        std::max<std::size_t>(1, std::max(word.size(), known[i].size()) / 3);
    if (edits > allowed || (best && edits >= least)) continue;
    best = i;
    least = edits;
  }
  return best;
}

}  // namespace diesink
