// The rows of a PLY file's elements, whatever they mean.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "formats/format.h"
#include "formats/ply_header.h"
#include "formats/ply_roles.h"

namespace diesink {

inline constexpr std::size_t kMaxPlyCorners = std::size_t{1} << 22;  // of one face or strip

// Reads rows through one of the Values (formats/ply_values.h, formats/ply_sections.h). Lengths are
// checked against what is left before anything is allocated.
template <class Values>
class PlyRows {
 public:
  // `text` and what else is given must outlive this.
  PlyRows(TextScanner& text, Values values, const PlyHeader& header, const ReadOptions& options)
      : text_(text), values_(std::move(values)), header_(header), options_(options) {}

  [[nodiscard]] TextScanner& text() { return text_; }
  [[nodiscard]] Values& values() { return values_; }
  [[nodiscard]] const PlyHeader& header() const { return header_; }
  [[nodiscard]] const ReadOptions& options() const { return options_; }
  [[nodiscard]] bool ascii() const { return header_.encoding == PlyEncoding::kAscii; }

  // A line and a column in text, a byte in binary data.
  [[nodiscard]] Place place(const char* at) const {
    return ascii() ? text_.place(at)
                   : Place{options_.file_name, 0, 0, static_cast<std::int64_t>(at - text_.begin())};
  }
  [[nodiscard]] Error error(std::string message, const char* at,
                            ErrorCode code = ErrorCode::kInput) const {
    return {code, std::move(message), place(at)};
  }
  // What went wrong with a value of the row that begins at `start`.
  [[nodiscard]] Error at_fault(const char* start) const {
    Error error = *values_.failed;
    if (!ascii()) error.where = place(start);
    return error;
  }

  // Whether the element's rows can be there at all.
  [[nodiscard]] Status check_size(const PlyElement& element) const {
    std::size_t row = 0;
    for (const PlyProperty& p : element.properties)
      row += Values::bytes(p.list ? p.count_type : p.type);
    if (element.count == 0) return ok();
    if (row == 0)
      return error("element " + quoted(element.name) + " has rows but no properties", text_.at());
    if (element.count > values_.left() / row) {
      return error(std::to_string(element.count) + " rows of " + quoted(element.name) +
                       " do not fit in the " + std::to_string(text_.left()) + " bytes left",
                   text_.at());
    }
    if (element.count > 0x7FFFFFFF)
      return error("more rows than 31 bits can count", text_.at(), ErrorCode::kLimit);
    return ok();
  }

  bool read_value(PlyType type, double& value) { return values_.read(type, value); }

  bool read_list(const PlyProperty& property, std::vector<double>& list) {
    std::size_t length = 0;
    const char* const start = text_.at();
    if (!read_length(property, length)) return false;
    if (length > kMaxPlyCorners) {
      values_.failed =
          error("a face of " + std::to_string(length) + " corners", start, ErrorCode::kLimit);
      return false;
    }
    list.resize(length);
    for (double& item : list) {
      if (!values_.read(property.type, item)) return false;
    }
    return true;
  }

  bool skip_property(const PlyProperty& property) {
    double value = 0;
    if (!property.list) return values_.read(property.type, value);
    std::size_t length = 0;
    if (!read_length(property, length)) return false;
    while (length-- > 0) {
      if (!values_.read(property.type, value)) return false;
    }
    return true;
  }

  // Calls `read` for the values of every row, then `take`, both with the row's start.
  template <class Read, class Take>
  Status each_row(const PlyElement& element, Read read, Take take) {
    for (std::uint64_t row = 0; row < element.count; ++row) {
      const char* const start = values_.begin_row();
      for (std::size_t p = 0; p < element.properties.size(); ++p) {
        if (!read(element.properties[p], p)) return at_fault(start);
      }
      values_.end_row();
      if (Status taken = take(start); !taken) return taken;
    }
    return ok();
  }

  Status skip(const PlyElement& element) {
    return each_row(
        element, [&](const PlyProperty& property, std::size_t) { return skip_property(property); },
        [](const char*) { return ok(); });
  }

  // Calls `take` with the row's values by role.
  template <class Take>
  Status each_row_by_role(const PlyElement& element, const PlyPlan& plan, Take take) {
    PlyRow row{};
    return each_row(
        element,
        [&](const PlyProperty& property, std::size_t p) {
          return property.list
                     ? skip_property(property)
                     : values_.read(property.type, row[static_cast<std::size_t>(plan.roles[p])]);
        },
        [&](const char* start) { return take(row, start); });
  }

 private:
  // The length of a list that fits in what is left.
  bool read_length(const PlyProperty& property, std::size_t& length) {
    double value = 0;
    const char* const start = text_.at();
    if (!values_.read(property.count_type, value)) return false;
    if (value < 0 || value > static_cast<double>(values_.left() / Values::bytes(property.type))) {
      values_.failed = error("a list of " + to_text(value) + " items does not fit in the " +
                                 std::to_string(text_.left()) + " bytes left",
                             start);
      return false;
    }
    length = static_cast<std::size_t>(value);
    return true;
  }

  TextScanner& text_;
  Values values_;
  const PlyHeader& header_;
  const ReadOptions& options_;
};

}  // namespace diesink
