// Splits the text into sections and puts together what they say.
// SPDX-License-Identifier: Apache-2.0
#include "core/part_program/part_program.h"

#include <algorithm>
#include <set>

#include "core/nearest.h"
#include "core/part_program/sections.h"

namespace diesink {
namespace {

enum SectionIndex : std::size_t { kSolids, kBase, kBoole, kMachining, kSectionCount };
const std::vector<std::string_view> kSectionWords = {"SOLID-DEF", "BSURF-DEF", "BOOLE-DEF",
                                                     "MACHI-DEF"};

// The name without folder and ending.
std::string stem_of(std::string_view file) {
  const std::size_t slash = file.find_last_of("/\\");
  if (slash != std::string_view::npos) file.remove_prefix(slash + 1);
  const std::size_t dot = file.rfind('.');
  return std::string(dot == std::string_view::npos || dot == 0 ? file : file.substr(0, dot));
}

class SectionSplitter {
 public:
  SectionSplitter(const Statements& statements, Report& report)
      : statements_(statements), report_(report) {}

  void run() {
    for (const Statement& s : statements_.list) {
      if (header(s)) continue;
      const std::string keyword = upper_case(s.fields[0].text);
      if (keyword == "UNITS" && units(s)) continue;
      if (current_ == kSectionCount) {
        std::vector<std::string_view> known = kSectionWords;
        known.emplace_back("UNITS");
        report_.error(s, s.column,
                      "unknown statement " + quoted(s.fields[0].text) +
                          " before the first section; " + word_list(known, "or") + " is expected" +
                          suggestion(keyword, known));
        continue;
      }
      if (!passed_over_) sections[current_].statements.push_back(&s);
    }
  }

  std::array<Section, kSectionCount> sections;
  LengthUnit unit = LengthUnit::kMillimetre;

 private:
  // Takes a statement that begins a section, in its right spelling or nearly so.
  bool header(const Statement& s) {
    const std::string keyword = upper_case(s.fields[0].text);
    auto word = std::ranges::find(kSectionWords, keyword);
    if (word == kSectionWords.end()) {
      if (s.field_count != 1 || keyword.find('-') == std::string::npos || is_expression(keyword)) {
        return false;
      }
      const std::optional<std::size_t> meant = nearest_word(keyword, kSectionWords);
      if (!meant) return false;
      report_.error(s, s.column,
                    "unknown section " + quoted(s.fields[0].text) + "; did you mean " +
                        std::string(kSectionWords[*meant]) + '?');
      word = kSectionWords.begin() + static_cast<std::ptrdiff_t>(*meant);
    } else if (s.field_count != 1) {
      report_.error(s, s.fields[1], keyword + " stands alone on its line");
    }
    current_ = static_cast<std::size_t>(word - kSectionWords.begin());
    Section& section = sections[current_];
    passed_over_ = section.header != nullptr;
    if (passed_over_) {
      report_.error(s, s.column,
                    std::string(*word) + " was already given at line " +
                        std::to_string(section.header->line));
    } else {
      section.header = &s;
    }
    return true;
  }

  // Whether a line like MACHI-DFE is a difference of solids that are so named.
  bool is_expression(const std::string& text) {
    if (current_ != kBoole) return false;
    if (firsts_.empty()) {
      for (const Statement& s : statements_.list) {
        if (s.field_count > 1) firsts_.insert(upper_case(s.fields[0].text));
      }
    }
    const std::size_t dash = text.find('-');
    return firsts_.count(text.substr(0, dash)) > 0 && firsts_.count(text.substr(dash + 1)) > 0;
  }

  // UNITS,MM or UNITS,INCH; false where the line is something else of a section.
  bool units(const Statement& s) {
    const std::vector<std::string_view> known = {"MM", "INCH"};
    const std::string word = s.field_count > 1 ? upper_case(s.fields[1].text) : std::string();
    const auto found = std::ranges::find(known, word);
    if (current_ != kSectionCount) {
      if (found == known.end()) return false;
      report_.error(s, s.column, "UNITS must stand before the first section");
      return true;
    }
    if (s.field_count != 2) {
      report_.error(s, s.column, "UNITS takes MM or INCH");
    } else if (found == known.end()) {
      report_.error(s, s.fields[1],
                    "unknown unit " + quoted(s.fields[1].text) + "; MM or INCH is expected" +
                        suggestion(word, known));
    } else if (units_ != nullptr) {
      report_.error(s, s.column, "UNITS was already given at line " + std::to_string(units_->line));
    } else if (word == "INCH") {
      unit = LengthUnit::kInch;
    }
    if (units_ == nullptr) units_ = &s;
    return true;
  }

  const Statements& statements_;
  Report& report_;
  std::size_t current_ = kSectionCount;  // none yet
  bool passed_over_ = false;             // a section given twice
  const Statement* units_ = nullptr;
  std::set<std::string, std::less<>> firsts_;
};

PartProgram read_sections(const Statements& statements, Report& report) {
  SectionSplitter split(statements, report);
  split.run();
  const std::array<Section, kSectionCount>& sections = split.sections;
  PartProgram program;
  program.unit = split.unit;

  SolidNames names;
  if (sections[kSolids].header != nullptr) {
    program.solids = read_solids(sections[kSolids], names, report);
  }
  // A base in error still counts as one, lest every B be an error too.
  bool has_base = false;
  if (sections[kBase].header != nullptr) {
    program.base = read_base(sections[kBase], report);
    const StatementList& base = sections[kBase].statements;
    has_base = base.empty() || upper_case(base[0]->fields[0].text) != "NONE";
  }
  MachiningSection machining;
  const Section no_section;
  machining =
      read_machining(sections[kMachining].header != nullptr ? sections[kMachining] : no_section,
                     program.unit, report);
  program.machining = machining.machining;
  if (sections[kBoole].header != nullptr) {
    program.boole = read_expression(sections[kBoole], names, &sections[kBase], has_base, report);
  } else {
    const std::string message = "the section BOOLE-DEF is missing";
    if (statements.list.empty()) {
      report.error(1, message);
    } else {
      const Statement& last = statements.list.back();
      report.error(last, last.column, message);
    }
  }
  if (!report.has_errors()) {
    const Statement& end = sections[kMachining].header != nullptr ? *sections[kMachining].header
                                                                  : *sections[kBoole].header;
    resolve_domain(program, machining, end, report);
  }
  return program;
}

}  // namespace

std::optional<PartProgram> parse_part_program(std::string_view text, std::string_view file_name,
                                              Diagnostics& diagnostics) {
  Report report(file_name);
  if (text.size() > kMaxProgramBytes) {
    report.error(1, "the part program has more than 16 MiB", ErrorCode::kLimit);
    report.hand_over(diagnostics);
    return std::nullopt;
  }
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF")) {
    report.error(1, "the text is in UTF-16; ASCII or UTF-8 is expected");
    report.hand_over(diagnostics);
    return std::nullopt;
  }
  const Statements statements = split_statements(text);
  if (statements.fault != LexFault::kNone) {
    report.error(statements.last_line,
                 statements.fault == LexFault::kLineTooLong
                     ? "the line is longer than the limit of 1 MiB"
                     : "the part program has more than the limit of 100000 statements",
                 ErrorCode::kLimit);
    report.hand_over(diagnostics);
    return std::nullopt;
  }
  PartProgram program = read_sections(statements, report);
  program.name = stem_of(file_name);
  program.file = file_name;
  const bool failed = report.has_errors();
  report.hand_over(diagnostics);
  if (failed) return std::nullopt;
  return program;
}

}  // namespace diesink
