// BOOLE-DEF: the expression over B and the solids, as steps from left to right.
// SPDX-License-Identifier: Apache-2.0
#include "core/part_program/sections.h"

namespace diesink {
namespace {

bool is_name_byte(char c) {
  return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
}

class ExpressionReader {
 public:
  ExpressionReader(const SolidNames& names, bool has_base, Report& report)
      : names_(names), has_base_(has_base), report_(report) {
    for (const auto& [id, statement] : names.declared) known_.push_back(id);
    if (has_base) known_.emplace_back("B");
  }

  // One line; the expression runs on over the next.
  void line(const Statement& s);
  // The end of the section.
  void end(const Statement& header);

  std::vector<BooleanStep> steps;

 private:
  struct Open {
    const Statement* statement;
    std::uint32_t column;
  };

  void sign(const Statement& s, std::uint32_t column, char c);
  void open(const Statement& s, std::uint32_t column);
  void close(const Statement& s, std::uint32_t column);
  void name(const Statement& s, std::uint32_t column, std::string_view word);
  // Tells a missing operator before a term or group.
  void operand_begins(const Statement& s, std::uint32_t column, std::string_view what);
  int surface_of(const Statement& s, std::uint32_t column, const std::string& id);

  const SolidNames& names_;
  bool has_base_;
  Report& report_;
  std::vector<std::string_view> known_;

  bool operand_next_ = true;    // a term or group is expected, not an operator
  bool operator_read_ = false;  // and an operator stands before it
  Sign sign_ = Sign::kPlus;
  std::vector<Open> open_;
  const Statement* last_ = nullptr;
  std::uint32_t last_column_ = 1;
  int rows_ = 0;
  std::size_t undefined_ = 0;
  bool too_long_ = false;
};

void ExpressionReader::line(const Statement& s) {
  for (std::size_t at = 0; at < s.body.size() && !too_long_;) {
    const char c = s.body[at];
    const std::uint32_t column = s.column + static_cast<std::uint32_t>(at);
    if (c == ' ' || c == '\t') {
      ++at;
      continue;
    }
    std::size_t end = at + 1;
    if (c == '+' || c == '-') {
      sign(s, column, c);
    } else if (c == '(') {
      open(s, column);
    } else if (c == ')') {
      close(s, column);
    } else if (is_name_byte(c)) {
      while (end < s.body.size() && is_name_byte(s.body[end])) ++end;
      name(s, column, s.body.substr(at, end - at));
    } else {
      // What follows on the line would only repeat the message.
      report_.error(s, column,
                    quoted(s.body.substr(at, 1)) +
                        " cannot stand in the expression; names, +, -, ( and ) can");
      operand_next_ = operator_read_ = false;
      last_ = &s;
      last_column_ = column;
      return;
    }
    last_ = &s;
    last_column_ = column;
    at = end;
  }
}

void ExpressionReader::sign(const Statement& s, std::uint32_t column, char c) {
  const std::string text = quoted(std::string_view(&c, 1));
  if (operand_next_ && operator_read_) {
    report_.error(s, column, "a name or ( is expected after the operator (got " + text + ')');
    return;
  }
  if (operand_next_ && c == '-' && !open_.empty()) {
    report_.error(s, column, "a group begins with an added term (got " + text + ')');
  } else if (operand_next_ && c == '-') {
    report_.warning(s, column, "the first term is subtracted from nothing and has no effect");
  }
  operand_next_ = operator_read_ = true;
  sign_ = c == '-' ? Sign::kMinus : Sign::kPlus;
}

void ExpressionReader::operand_begins(const Statement& s, std::uint32_t column,
                                      std::string_view what) {
  if (!operand_next_) report_.error(s, column, "+ or - is expected before " + std::string(what));
}

void ExpressionReader::open(const Statement& s, std::uint32_t column) {
  operand_begins(s, column, "(");
  if (operand_next_ && sign_ == Sign::kMinus) {
    report_.error(s, column, "a group may not be subtracted; only single solids may");
  }
  if (open_.size() == kMaxNesting) {
    report_.error(s, column, "groups are nested deeper than the limit of 64", ErrorCode::kLimit);
    too_long_ = true;
    return;
  }
  open_.push_back({&s, column});
  steps.push_back({BooleanStep::Kind::kGroupOpen, Sign::kPlus, 0, 0});
  operand_next_ = true;
  operator_read_ = false;
  sign_ = Sign::kPlus;
}

void ExpressionReader::close(const Statement& s, std::uint32_t column) {
  if (open_.empty()) {
    report_.error(s, column, ") closes no group");
    return;
  }
  if (operand_next_) {
    report_.error(s, column,
                  operator_read_ ? "a name or ( is expected after the operator (got \")\")"
                                 : "the group is empty");
  }
  open_.pop_back();
  steps.push_back({BooleanStep::Kind::kGroupClose, Sign::kPlus, 0, 0});
  operand_next_ = operator_read_ = false;
  sign_ = Sign::kPlus;
}

void ExpressionReader::name(const Statement& s, std::uint32_t column, std::string_view word) {
  const std::string id = upper_case(word);
  operand_begins(s, column, quoted(word));
  if (static_cast<std::size_t>(rows_) == kMaxStatements) {
    report_.error(s, column, "the expression has more than 100000 terms", ErrorCode::kLimit);
    too_long_ = true;
    return;
  }
  const int surface = surface_of(s, column, id);
  steps.push_back({BooleanStep::Kind::kTerm, sign_, surface, rows_++});
  operand_next_ = operator_read_ = false;
  sign_ = Sign::kPlus;
}

// 0 for the base and for what is in error.
int ExpressionReader::surface_of(const Statement& s, std::uint32_t column, const std::string& id) {
  if (id == "B") {
    if (!has_base_) {
      report_.error(s, column, "B is not defined: the program has no base surface (BSURF-DEF)");
    } else if (sign_ == Sign::kMinus) {
      report_.error(s, column, "B may not be subtracted; only solids may");
    }
    return 0;
  }
  const auto found = names_.surface.find(id);
  if (found != names_.surface.end()) return found->second;
  if (names_.declared.find(id) == names_.declared.end()) {
    // Short names such as S1 and S9 are all near each other; only longer ones are misspelt. Beyond
    // the messages that are shown the search through all names would only cost time.
    const bool suggest = id.size() > 2 && ++undefined_ <= kMaxErrors;
    report_.error(
        s, column,
        quoted(id) + " is not defined" + (suggest ? suggestion(id, known_) : std::string()));
  }
  return 0;
}

void ExpressionReader::end(const Statement& header) {
  if (too_long_) return;
  if (last_ == nullptr) {
    report_.error(header, header.column,
                  "BOOLE-DEF is empty; an expression such as B+S1-S2 is expected");
    return;
  }
  if (operator_read_) {
    report_.error(*last_, last_column_,
                  "the expression ends with an operator; a name is expected after it");
  }
  for (const Open& group : open_) report_.error(*group.statement, group.column, "( is not closed");
}

}  // namespace

std::vector<BooleanStep> read_expression(const Section& section, const SolidNames& names,
                                         const Section* base_section, bool has_base,
                                         Report& report) {
  const std::size_t errors = report.error_count();
  ExpressionReader reader(names, has_base, report);
  for (const Statement* s : section.statements) reader.line(*s);
  reader.end(*section.header);
  // What an expression in error leaves out says nothing.
  if (report.error_count() > errors) return std::move(reader.steps);

  std::vector<bool> used(names.surface.size() + 1, false);
  for (const BooleanStep& step : reader.steps) {
    if (step.kind == BooleanStep::Kind::kTerm) used[static_cast<std::size_t>(step.surface)] = true;
  }
  for (const auto& [number, header] : names.header) {
    if (!used[static_cast<std::size_t>(number)]) {
      report.warning(*header, header->fields[0].column,
                     upper_case(header->fields[0].text) + " does not stand in the expression");
    }
  }
  if (has_base && base_section != nullptr && !used[0]) {
    report.warning(*base_section->header, base_section->header->column,
                   "the base surface does not stand in the expression");
  }
  return std::move(reader.steps);
}

}  // namespace diesink
