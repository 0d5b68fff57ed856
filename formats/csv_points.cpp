// SPDX-License-Identifier: Apache-2.0
#include "formats/csv_points.h"

#include <cmath>
#include <cstring>
#include <span>

#include "formats/text_number.h"
#include "formats/text_scanner.h"

namespace diesink {
namespace {

constexpr std::size_t kMostErrors = 20;
constexpr double kLargestCoordinate = 1e9;

// A field and where it stands.
struct Field {
  std::string_view text;
  std::size_t column = 1;  // from 1
};

Field trimmed(std::string_view text, std::size_t column) {
  while (!text.empty() && is_blank(text.front())) {
    text.remove_prefix(1);
    ++column;
  }
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return {text, column};
}

void split(std::string_view line, std::vector<Field>& fields) {
  fields.clear();
  std::size_t begin = 0;
  while (true) {
    const std::size_t comma = line.find(',', begin);
    fields.push_back(trimmed(
        line.substr(begin, comma == std::string_view::npos ? comma : comma - begin), begin + 1));
    if (comma == std::string_view::npos) return;
    begin = comma + 1;
  }
}

bool is_word(std::string_view text, char lower) {
  return text.size() == 1 && (text[0] == lower || text[0] == lower - 'a' + 'A');
}

class PointReader {
 public:
  PointReader(const std::string& file_name, Diagnostics& diagnostics)
      : file_name_(file_name), diagnostics_(diagnostics) {}

  void line(std::string_view text, std::uint32_t number) {
    number_ = number;
    text_ = text;
    if (text.size() > kMaxLineBytes) {
      text_ = {};
      error(1, "a line of " + std::to_string(text.size()) + " bytes; expected at most 1 MiB");
      return;
    }
    text = text.substr(0, text.find('#'));
    if (trimmed(text, 1).text.empty()) return;
    split(text, fields_);
    if (!begun_) {
      begun_ = true;
      if (header()) return;
    }
    point();
  }

  std::vector<Vec2> take() { return std::move(points_); }

 private:
  void error(std::size_t column, std::string message) {
    Place place{file_name_, number_, static_cast<std::uint32_t>(column)};
    diagnostics_.error(std::move(message), std::move(place), std::string(text_));
  }

  // A first line that names columns x and y.
  bool header() {
    std::size_t x = kNone, y = kNone;
    for (std::size_t k = 0; k < fields_.size(); ++k) {
      if (is_word(fields_[k].text, 'x')) x = k;
      if (is_word(fields_[k].text, 'y')) y = k;
    }
    if (x == kNone || y == kNone) return false;
    x_ = x;
    y_ = y;
    columns_ = fields_.size();
    named_ = true;
    return true;
  }

  void point() {
    if (fields_.size() != columns_) {
      error(fields_.size() > columns_ ? fields_[columns_].column : fields_.back().column,
            std::to_string(fields_.size()) + (fields_.size() == 1 ? " field" : " fields") +
                "; expected " +
                (named_ ? std::to_string(columns_) + ", as the header has"
                        : std::string("two: x,y")));
      return;
    }
    Vec2 p;
    if (coordinate(fields_[x_], p.x()) && coordinate(fields_[y_], p.y())) points_.push_back(p);
  }

  bool coordinate(const Field& field, double& value) {
    const std::optional<double> number = number_of(field.text);
    if (!number) {
      error(field.column, quoted(field.text) + " is not a number; expected a coordinate");
      return false;
    }
    if (std::fabs(*number) > kLargestCoordinate) {
      error(field.column, "coordinate " + quoted(field.text) + "; expected at most 1e9");
      return false;
    }
    value = *number;
    return true;
  }

  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  const std::string& file_name_;
  Diagnostics& diagnostics_;
  std::vector<Vec2> points_;
  std::vector<Field> fields_;
  std::string_view text_;
  std::uint32_t number_ = 0;
  std::size_t x_ = 0, y_ = 1, columns_ = 2;
  bool begun_ = false, named_ = false;
};

}  // namespace

std::vector<Vec2> read_csv_points(std::string_view text, const std::string& file_name,
                                  Diagnostics& diagnostics) {
  text = text_of(std::as_bytes(std::span(text)));
  PointReader reader(file_name, diagnostics);
  std::uint32_t number = 0;
  while (!text.empty() && diagnostics.error_count() < kMostErrors) {
    const std::size_t end = text.find('\n');
    std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    reader.line(line, ++number);
  }
  return reader.take();
}

}  // namespace diesink
