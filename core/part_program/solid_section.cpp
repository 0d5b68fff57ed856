// SOLID-DEF: headers and data statements of the primitives, by the table of kinds.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "core/nearest.h"
#include "core/number.h"
#include "core/part_program/sections.h"
#include "core/solids/frame.h"
#include "core/solids/kinds.h"

namespace diesink {
namespace {

bool is_letter(char c) { return c >= 'A' && c <= 'Z'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

// A letter followed by letters or digits, in upper case.
bool is_identifier(std::string_view word) {
  return !word.empty() && is_letter(word.front()) &&
         std::ranges::all_of(word, [](char c) { return is_letter(c) || is_digit(c); });
}

std::vector<std::string_view> keywords_of(const SolidOption& option) {
  std::vector<std::string_view> words;
  for (const FieldKind& field : option.fields) words.push_back(field.keyword);
  return words;
}

class SolidReader {
 public:
  SolidReader(SolidNames& names, Report& report) : names_(names), report_(report) {}

  void statement(const Statement& s);
  std::vector<Solid> take() {
    finish();
    return std::move(solids_);
  }

 private:
  // What a second field says of its statement.
  enum class Second : std::uint8_t { kType, kNearType, kNumber, kOther };

  Second second_field(std::string_view word) const;
  void header(const Statement& s);
  void data(const Statement& s, std::size_t index);
  void stray(const Statement& s, const std::string& keyword);
  void finish();

  SolidNames& names_;
  Report& report_;
  std::vector<Solid> solids_;
  const std::vector<std::string_view> types_ = solid_type_words();
  const std::vector<std::string_view> all_fields_ = solid_field_words();

  // The solid being read. Where its header is in error its data statements are passed over.
  const Statement* header_ = nullptr;
  std::string id_;
  const SolidKind* kind_ = nullptr;
  const SolidOption* option_ = nullptr;
  std::vector<FieldValue> values_;
  std::vector<const Statement*> given_;
  bool good_ = false;
};

SolidReader::Second SolidReader::second_field(std::string_view word) const {
  if (find_solid_kind(word) != nullptr) return Second::kType;
  double number = 0;
  if (read_number(word, number) != NumberFault::kNotANumber) return Second::kNumber;
  if (nearest_word(word, types_)) return Second::kNearType;
  const bool begins_like_one = word.empty() || is_digit(word.front()) ||
                               std::string_view("+-.").find(word.front()) != std::string_view::npos;
  return begins_like_one ? Second::kNumber : Second::kOther;
}

void SolidReader::statement(const Statement& s) {
  const std::string keyword = upper_case(s.fields[0].text);
  std::size_t index = 0;
  const std::size_t count = option_ == nullptr ? 0 : option_->fields.size();
  while (index < count && option_->fields[index].keyword != keyword) ++index;
  const bool known = index < count;

  if (s.field_count == 1) return known ? data(s, index) : stray(s, keyword);
  switch (second_field(upper_case(s.fields[1].text))) {
    case Second::kType:
    case Second::kNearType:
      return header(s);
    case Second::kNumber:
      return known ? data(s, index) : stray(s, keyword);
    case Second::kOther:
      return known ? data(s, index) : header(s);
  }
}

void SolidReader::header(const Statement& s) {
  finish();
  header_ = &s;
  good_ = false;
  kind_ = nullptr;
  option_ = nullptr;
  id_ = upper_case(s.fields[0].text);

  if (!is_identifier(id_) || id_ == "B") {
    report_.error(s, s.fields[0],
                  id_ == "B" ? std::string("B names the base surface; a solid needs another ID")
                             : quoted(s.fields[0].text) +
                                   " is not an ID; a letter followed by letters or digits is");
  } else if (const auto [first, is_new] = names_.declared.try_emplace(id_, &s); !is_new) {
    report_.error(s, s.fields[0],
                  id_ + " was already defined at line " + std::to_string(first->second->line));
  } else {
    good_ = true;
  }

  const std::string type = upper_case(s.fields[1].text);
  kind_ = find_solid_kind(type);
  if (kind_ == nullptr) {
    good_ = false;
    std::string message = "unknown solid type " + quoted(s.fields[1].text);
    const std::string meant = suggestion(type, types_);
    if (meant.empty()) {
      std::vector<std::string_view> keywords;
      for (const SolidKind* kind : solid_kinds()) keywords.push_back(kind->keyword);
      message += "; known are " + word_list(keywords);
    }
    report_.error(s, s.fields[1], message + meant);
    return;
  }
  const int options = static_cast<int>(kind_->options.size());
  int option = 1;
  if (s.field_count > 3) {
    good_ = false;
    report_.error(s, s.fields[3],
                  "a header is ID,TYPE,OPTION (got " + std::to_string(s.field_count) + " fields)");
  }
  if (s.field_count >= 3 &&
      !read_count(s, 2, 1, options,
                  std::string(kind_->keyword) + " has the options 1 to " + std::to_string(options),
                  option, report_)) {
    good_ = false;
    return;
  }
  option_ = &kind_->options[static_cast<std::size_t>(option - 1)];
  values_.assign(option_->fields.size(), {});
  given_.assign(option_->fields.size(), nullptr);
}

void SolidReader::data(const Statement& s, std::size_t index) {
  const FieldKind& field = option_->fields[index];
  if (given_[index] != nullptr) {
    good_ = false;
    report_.error(s, s.fields[0],
                  std::string(field.keyword) + " of " + id_ + " was already given at line " +
                      std::to_string(given_[index]->line));
    return;
  }
  given_[index] = &s;
  const bool vector = field.shape == FieldShape::kPoint || field.shape == FieldShape::kDirection;
  FieldValue& value = values_[index];
  if (!read_numbers(s, 1, vector ? 3 : 1, field.shape != FieldShape::kDirection, field.keyword,
                    value.value.data(), report_)) {
    good_ = false;
    return;
  }
  value.where = {{}, s.line, s.fields[1].column, -1};
  const double length = value.value[0];
  std::string fault;
  if (field.shape == FieldShape::kDirection && value.value.isZero(0)) {
    fault = " must not be the zero vector";
  } else if (field.shape == FieldShape::kLength && length <= 0) {
    fault = " must be greater than 0 (got " + number_text(length) + ')';
  } else if (field.shape == FieldShape::kHeight && length == 0) {
    fault = " must not be 0";
  } else if (!vector && field.shape != FieldShape::kPoint && std::abs(length) < kLeastLength) {
    fault = " is below the least length of 1e-9 (got " + number_text(length) + ')';
  }
  if (!fault.empty()) {
    good_ = false;
    report_.error(s, s.fields[1], std::string(field.keyword) + fault);
  }
}

// A statement that is neither a header nor one of the solid's data.
void SolidReader::stray(const Statement& s, const std::string& keyword) {
  if (header_ != nullptr && option_ == nullptr && s.field_count > 1)
    return;  // its header was in error
  const bool is_data = std::ranges::find(all_fields_, keyword) != all_fields_.end();
  if (option_ == nullptr) {
    report_.error(
        s, s.fields[0],
        is_data ? keyword + " stands before the first solid; a header ID,TYPE,OPTION is expected"
                : "unknown statement " + quoted(s.body) + "; a header ID,TYPE,OPTION is expected" +
                      suggestion(keyword, all_fields_));
    return;
  }
  good_ = false;
  const std::vector<std::string_view> own = keywords_of(*option_);
  std::string message =
      is_data ? id_ + " takes no " + keyword : "unknown statement " + quoted(s.fields[0].text);
  message += "; " + std::string(kind_->keyword) + " option " + std::to_string(option_->number) +
             " takes " + word_list(own);
  if (!is_data) message += suggestion(keyword, own);
  report_.error(s, s.fields[0], message);
  // The statement it was meant to be is not missing as well.
  const std::optional<std::size_t> meant = meant_word(keyword, own);
  if (!is_data && meant && given_[*meant] == nullptr) given_[*meant] = &s;
}

// Checks that the solid is complete and builds its body.
void SolidReader::finish() {
  if (header_ == nullptr || option_ == nullptr) return;
  const Statement& s = *header_;
  std::vector<std::string_view> missing;
  for (std::size_t k = 0; k < given_.size(); ++k) {
    if (given_[k] == nullptr) missing.push_back(option_->fields[k].keyword);
  }
  if (!missing.empty()) {
    report_.error(s, s.fields[0],
                  id_ + " lacks " + word_list(missing) + "; " + std::string(kind_->keyword) +
                      " option " + std::to_string(option_->number) + " takes " +
                      word_list(keywords_of(*option_)));
  } else if (good_) {
    const Result<Body> body = option_->make(values_);
    if (body) {
      solids_.push_back(
          {id_, kind_->keyword, option_->number, *body, report_.place(s, s.fields[0].column)});
      const int number = static_cast<int>(solids_.size());
      names_.surface.emplace(id_, number);
      names_.header.emplace(number, &s);
    } else {
      const Place& where = body.error().where;
      const auto at = std::ranges::find_if(
          given_, [&](const Statement* given) { return given->line == where.line; });
      const bool placed = at != given_.end();
      report_.error(placed ? **at : s, placed ? where.column : s.fields[0].column,
                    id_ + ": " + body.error().message);
    }
  }
  header_ = nullptr;
  option_ = nullptr;
}

}  // namespace

std::vector<Solid> read_solids(const Section& section, SolidNames& names, Report& report) {
  SolidReader reader(names, report);
  for (const Statement* s : section.statements) reader.statement(*s);
  return reader.take();
}

}  // namespace diesink
