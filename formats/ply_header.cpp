// SPDX-License-Identifier: Apache-2.0
#include "formats/ply_header.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

namespace diesink {
namespace {

constexpr std::size_t kMaxElements = 64, kMaxProperties = 256, kMaxComments = 200'000;

std::optional<PlyType> type_of(std::string_view word) {
  using Name = std::pair<std::string_view, PlyType>;
  constexpr std::array kNames{Name{"char", PlyType::kInt8},     Name{"int8", PlyType::kInt8},
                              Name{"uchar", PlyType::kUint8},   Name{"uint8", PlyType::kUint8},
                              Name{"short", PlyType::kInt16},   Name{"int16", PlyType::kInt16},
                              Name{"ushort", PlyType::kUint16}, Name{"uint16", PlyType::kUint16},
                              Name{"int", PlyType::kInt32},     Name{"int32", PlyType::kInt32},
                              Name{"uint", PlyType::kUint32},   Name{"uint32", PlyType::kUint32},
                              Name{"float", PlyType::kFloat},   Name{"float32", PlyType::kFloat},
                              Name{"double", PlyType::kDouble}, Name{"float64", PlyType::kDouble}};
  for (const Name& name : kNames) {
    if (name.first == word) return name.second;
  }
  return std::nullopt;
}

class HeaderReader {
 public:
  explicit HeaderReader(TextScanner& text) : text_(text) {}

  Result<PlyHeader> read() {
    if (const char* const at = text_.at(); text_.word() != "ply")
      return text_.error("expected 'ply'", at);
    bool format = false;
    while (text_.more()) {
      const char* const line = text_.at();
      const std::string_view word = text_.word();
      if (word == "end_header") {
        end_line();
        if (!format) return text_.error("the header has no 'format' line", line);
        return std::move(header_);
      }
      Status read_line = ok();
      if (word == "format") {
        format = true;
        read_line = read_format();
      } else if (word == "comment" || word == "obj_info") {
        if (header_.comments.size() < kMaxComments)
          header_.comments.push_back(text_.rest_of_line());
      } else if (word == "element") {
        read_line = read_element();
      } else if (word == "property") {
        read_line = read_property();
      } else {
        return text_.error(
            "found " + quoted(word) + ", expected 'element', 'property' or 'end_header'", line);
      }
      if (!read_line) return read_line.error();
      const char* const rest = text_.at();
      if (!text_.rest_of_line().empty()) {
        return text_.error("more words than " + quoted(word) + " takes", rest);
      }
    }
    return text_.error("the file ends in the header, expected 'end_header'");
  }

 private:
  void end_line() {
    const char* at = text_.at();
    while (at != text_.end() && is_blank(*at)) ++at;
    if (at != text_.end() && *at == '\r') ++at;
    // Where a CR alone ends lines, a line feed after it is the data's first byte.
    if (at != text_.end() && *at == '\n' && (at[-1] != '\r' || !text_.has_lone_cr())) ++at;
    text_.move_to(at);
  }

  Status read_format() {
    text_.more_in_line();
    const char* const at = text_.at();
    const std::string_view word = text_.word();
    if (word == "ascii") {
      header_.encoding = PlyEncoding::kAscii;
    } else if (word == "binary_little_endian") {
      header_.encoding = PlyEncoding::kLittleEndian;
    } else if (word == "binary_big_endian") {
      header_.encoding = PlyEncoding::kBigEndian;
    } else {
      return text_.error("unknown format " + quoted(word) +
                             ", expected ascii, binary_little_endian or "
                             "binary_big_endian",
                         at);
    }
    if (const std::string_view version = text_.word(); version != "1.0") {
      return text_.error("found version " + quoted(version) + ", expected 1.0", at);
    }
    return ok();
  }

  Status read_element() {
    text_.more_in_line();
    const char* const at = text_.at();
    PlyElement element;
    element.named_at = at;
    element.name = std::string(text_.word());
    const std::string_view word = text_.word();
    const std::optional<std::int64_t> count = integer_of(word);
    if (element.name.empty() || !count || *count < 0) {
      return text_.error("found " + quoted(word) + " as the number of " + quoted(element.name), at);
    }
    element.count = static_cast<std::uint64_t>(*count);
    const bool again = std::any_of(header_.elements.begin(), header_.elements.end(),
                                   [&](const PlyElement& e) { return e.name == element.name; });
    if (again) return text_.error("a second element " + quoted(element.name), at);
    if (header_.elements.size() == kMaxElements) return text_.error("more than 64 elements", at);
    header_.elements.push_back(std::move(element));
    return ok();
  }

  Status read_property() {
    text_.more_in_line();
    const char* const at = text_.at();
    if (header_.elements.empty()) return text_.error("a property before the first element", at);
    PlyElement& element = header_.elements.back();
    PlyProperty property;
    std::string_view word = text_.word();
    if (word == "list") {
      property.list = true;
      word = text_.word();
      const std::optional<PlyType> count = type_of(word);
      if (!count) return text_.error("unknown type " + quoted(word) + " of a list's length", at);
      if (is_real(*count)) {
        return text_.error(
            "found " + quoted(word) + ", expected a whole-number type for a list's length", at);
      }
      property.count_type = *count;
      word = text_.word();
    }
    const std::optional<PlyType> type = type_of(word);
    if (!type) return text_.error("unknown type " + quoted(word) + " of a property", at);
    property.type = *type;
    property.name = std::string(text_.word());
    if (property.name.empty()) return text_.error("a property without a name", at);
    if (element.find(property.name) != nullptr) {
      return text_.error(
          "a second property " + quoted(property.name) + " of " + quoted(element.name), at);
    }
    if (element.properties.size() == kMaxProperties)
      return text_.error("more than 256 properties", at);
    element.properties.push_back(std::move(property));
    return ok();
  }

  TextScanner& text_;
  PlyHeader header_;
};

}  // namespace

const PlyProperty* PlyElement::find(std::string_view property) const {
  for (const PlyProperty& p : properties) {
    if (p.name == property) return &p;
  }
  return nullptr;
}

Result<PlyHeader> read_ply_header(TextScanner& text) { return HeaderReader(text).read(); }

}  // namespace diesink
