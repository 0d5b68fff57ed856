// SPDX-License-Identifier: Apache-2.0
#include "formats/off_rows.h"

#include <cmath>
#include <string>

namespace diesink {

std::string_view off_comment(TextScanner& text) {
  std::string_view comment = text.rest_of_line();
  while (!comment.empty() && (comment[0] == '#' || is_blank(comment[0]))) comment.remove_prefix(1);
  return comment;
}

bool OffRowReader::more(OffRows& rows) {
  while (text_.more() && *text_.at() == '#') rows.comments.push_back(off_comment(text_));
  return !text_.at_end();
}

Status OffRowReader::read(std::size_t number, OffRows& rows) {
  const bool vertex = number < vertices_;
  if (!more(rows)) {
    return text_.error(
        "the file ends after " + std::to_string(vertex ? number : number - vertices_) + " of " +
        std::to_string(vertex ? vertices_ : faces_) + (vertex ? " vertices" : " faces"));
  }
  OffRows::Row row{text_.at(), rows.numbers.size(), 0, 0, 0};
  if (Status own = vertex ? read_coordinates(rows) : read_corners(rows); !own) return own;
  row.rest = rows.numbers.size();
  if (Status rest = read_rest(rows, row.whole); !rest) return rest;
  row.end = rows.numbers.size();
  rows.end = text_.at();
  rows.rows.push_back(row);
  return ok();
}

Status OffRowReader::read_coordinates(OffRows& rows) {
  for (int k = 0; k < 3; ++k) {
    if (k > 0 && !more_in_line())
      return text_.number_error(NumberState::kNotANumber, "three coordinates");
    double x = 0;
    const NumberState state = text_.number(x);
    if (state != NumberState::kOk) return text_.number_error(state, "a coordinate");
    if (std::abs(x) > options_.max_coordinate) {
      Error over = text_.error("coordinate " + to_text(x) + " is beyond the limit of " +
                               to_text(options_.max_coordinate));
      over.code = ErrorCode::kLimit;
      return over;
    }
    rows.numbers.push_back(x);
  }
  return ok();
}

Status OffRowReader::read_corners(OffRows& rows) {
  const char* const start = text_.at();
  std::uint64_t corners = 0;
  if (!text_.digits(corners) || corners < 1) {
    text_.move_to(start);
    const std::string_view word = text_.word();
    const std::optional<std::int64_t> written = integer_of(word);
    if (!written || *written < 1) {
      return text_.error("found " + quoted(word) + ", expected the number of the face's corners",
                         start);
    }
    corners = static_cast<std::uint64_t>(*written);
  }
  if (corners > text_.left() / 2 + 1) {
    return text_.error("a face of " + std::to_string(corners) + " corners does not fit in the " +
                           std::to_string(text_.left()) + " bytes left",
                       start);
  }
  for (std::uint64_t i = 0; i < corners; ++i) {
    more(rows);
    const char* const at = text_.at();
    if (std::uint64_t index = 0; text_.digits(index) && index < vertices_) {
      rows.numbers.push_back(static_cast<double>(index));
      continue;
    }
    text_.move_to(at);
    const std::string_view index_word = text_.word();
    const std::optional<std::int64_t> index = integer_of(index_word);
    if (!index || *index < 0 || *index >= static_cast<std::int64_t>(vertices_)) {
      return text_.error((index_word.empty() ? "the file ends" : "found " + quoted(index_word)) +
                             ", expected the number of a vertex from 0 to " +
                             std::to_string(static_cast<std::int64_t>(vertices_) - 1),
                         at);
    }
    rows.numbers.push_back(static_cast<double>(*index));
  }
  return ok();
}

// All numbers of the rest of the line.
Status OffRowReader::read_rest(OffRows& rows, std::uint32_t& whole) {
  for (std::uint32_t i = 0; i < 16 && more_in_line(); ++i) {
    const char* const at = text_.at();
    double value = 0;
    if (const NumberState state = text_.number(value); state != NumberState::kOk) {
      return text_.number_error(state, "a number");
    }
    rows.numbers.push_back(value);
    if (integer_of({at, static_cast<std::size_t>(text_.at() - at)})) whole |= 1U << i;
  }
  return ok();
}

}  // namespace diesink
