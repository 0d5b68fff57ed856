// The rows of an OFF file: a vertex or a face each.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "formats/format.h"
#include "formats/text_scanner.h"

namespace diesink {

// The text of the comment at the cursor, which goes to the line's end.
std::string_view off_comment(TextScanner& text);

// What a vertex's or a face's line holds, one after the other.
struct OffRows {
  struct Row {
    const char* start;
    std::size_t first, rest, end;  // in `numbers`: its own numbers, and those after them
    std::uint32_t whole;           // bit i: number i after its own is written as a whole number
  };
  std::vector<Row> rows;
  std::vector<double> numbers;
  std::vector<std::string_view> comments;
  const char* end = nullptr;  // behind the last row

  [[nodiscard]] std::span<const double> own(const Row& row) const {
    return std::span(numbers).subspan(row.first, row.rest - row.first);
  }
  [[nodiscard]] std::span<const double> rest(const Row& row) const {
    return std::span(numbers).subspan(row.rest, row.end - row.rest);
  }
  void clear() {
    rows.clear();
    numbers.clear();
    comments.clear();
    end = nullptr;
  }
};

// Reads rows; the text's cursor goes behind what was read.
class OffRowReader {
 public:
  // `text` must outlive this. `vertices` and `faces`: how many the file announces.
  OffRowReader(TextScanner& text, const ReadOptions& options, std::size_t vertices,
               std::size_t faces)
      : text_(text), options_(options), vertices_(vertices), faces_(faces) {}

  // Skips comments and blanks; true where something is left.
  bool more(OffRows& rows);

  // The row with this number, vertices before faces: three coordinates, or the numbers of a face's
  // vertices, each checked, and what else is on the line.
  Status read(std::size_t number, OffRows& rows);

 private:
  bool more_in_line() { return text_.more_in_line() && *text_.at() != '#'; }
  Status read_coordinates(OffRows& rows);
  Status read_corners(OffRows& rows);
  Status read_rest(OffRows& rows, std::uint32_t& whole);

  TextScanner& text_;
  const ReadOptions& options_;
  std::size_t vertices_, faces_;
};

}  // namespace diesink
