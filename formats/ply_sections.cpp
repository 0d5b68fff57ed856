// SPDX-License-Identifier: Apache-2.0
#include "formats/ply_sections.h"

#include <algorithm>

#include "formats/plain_lines.h"
#include "formats/ply_values.h"

namespace diesink {
namespace {

std::size_t count_rows(TextScanner text) {
  if (const auto plain = plain_row_count({text.at(), text.left()})) return *plain;
  std::size_t rows = 0;
  while (text.more()) {
    ++rows;
    text.skip_line();
  }
  return rows;
}

// Reads the lines of a section as rows; false where they are not what the header announces.
class SectionReader {
 public:
  SectionReader(TextScanner text, const PlyHeader& header, PlySection& section)
      : text_(std::move(text)), values_(text_), header_(header), section_(section) {}

  bool read(std::size_t row) {
    section_.begin = section_.end = text_.at();
    section_.values.clear();
    section_.starts.clear();
    section_.longer = {};
    section_.values.reserve(text_.left() / 6);
    auto element = header_.elements.begin();
    for (; element != header_.elements.end() && row >= element->count; ++element) {
      row -= static_cast<std::size_t>(element->count);
    }
    for (; element != header_.elements.end(); ++element, row = 0) {
      for (; row < element->count; ++row) {
        if (!text_.more()) return true;
        section_.starts.push_back(static_cast<std::uint32_t>(text_.at() - section_.begin));
        if (!read_row(*element)) return false;
        values_.end_row();
        section_.longer = values_.longer;
        section_.end = text_.at();
      }
    }
    return true;
  }

 private:
  bool read_row(const PlyElement& element) {
    return std::all_of(element.properties.begin(), element.properties.end(),
                       [&](const PlyProperty& property) {
                         if (!property.list) return read_value(property.type);
                         if (!read_value(property.count_type)) return false;
                         // A list ends with its line at the latest.
                         for (double length = section_.values.back(); length > 0; --length) {
                           if (!read_value(property.type)) return false;
                         }
                         return true;
                       });
  }

  bool read_value(PlyType type) {
    double value = 0;
    if (!text_.more_in_line() || !values_.read(type, value)) return false;
    section_.values.push_back(value);
    return true;
  }

  TextScanner text_;
  AsciiValues values_;
  const PlyHeader& header_;
  PlySection& section_;
};

}  // namespace

bool PlySectionValues::fit(const TextScanner& text, const PlyHeader& header,
                           const ReadOptions& options) {
  if (header.encoding != PlyEncoding::kAscii || section_count(text.left(), options) == 1) {
    return false;
  }
  // Rows without properties take no line, and faces before the vertices are read a second time.
  bool vertices = false;
  for (const PlyElement& element : header.elements) {
    if (element.properties.empty()) return false;
    vertices = vertices || element.name == "vertex";
    if (!vertices && (element.name == "face" || element.name == "tristrips")) return false;
  }
  return true;
}

PlySectionValues::PlySectionValues(TextScanner& text, const PlyHeader& header,
                                   const ReadOptions& options)
    : text_(text),
      sections_(std::make_unique<SectionQueue<PlySection>>(
          text, options, count_rows,
          [&header](TextScanner part, std::size_t first_row, std::size_t, PlySection& section) {
            return SectionReader(std::move(part), header, section).read(first_row);
          })),
      end_(text.at()) {}

const char* PlySectionValues::begin_row() {
  while (section_ == nullptr || row_ == section_->starts.size()) {
    section_ = sections_->next();
    row_ = 0;
    if (section_ == nullptr) {
      at_ = last_ = nullptr;
      return end_;
    }
    at_ = section_->values.data();
    last_ = at_ + section_->values.size();
    longer.add(section_->longer);
    if (!section_->starts.empty()) end_ = section_->end;
  }
  return section_->begin + section_->starts[row_];
}

bool PlySectionValues::fail() {
  failed = text_.error("the rows are not one a line");
  return false;
}

}  // namespace diesink
