// MACHI-DEF: domain, spacing, tolerances, cutter.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/number.h"
#include "core/part_program/sections.h"

namespace diesink {
namespace {

enum class Rule : std::uint8_t { kRange, kPositive, kNotNegative, kAny, kCutter };

struct StatementKind {
  std::string_view keyword;
  std::size_t numbers;
  Rule rule;
  void (*store)(Machining&, const double*);
};

constexpr StatementKind kStatements[] = {
    {"X-RNG", 2, Rule::kRange,
     [](Machining& m, const double* v) {
       m.x_range = {v[0], v[1]};
     }},
    {"Y-RNG", 2, Rule::kRange,
     [](Machining& m, const double* v) {
       m.y_range = {v[0], v[1]};
     }},
    {"X-INT", 1, Rule::kPositive, [](Machining& m, const double* v) { m.x_interval = v[0]; }},
    {"Y-INT", 1, Rule::kPositive,
     [](Machining& m, const double* v) {
       m.y_interval = v[0];
       m.y_interval_stated = true;
     }},
    {"TOLER", 1, Rule::kPositive, [](Machining& m, const double* v) { m.tolerance = v[0]; }},
    {"INTOL", 1, Rule::kNotNegative, [](Machining& m, const double* v) { m.intol = v[0]; }},
    {"OUTTOL", 1, Rule::kNotNegative, [](Machining& m, const double* v) { m.outtol = v[0]; }},
    {"CUTTER", 2, Rule::kCutter,
     [](Machining& m, const double* v) {
       m.cutter = Cutter{v[0], v[1]};
     }},
    {"CUSP", 1, Rule::kPositive, [](Machining& m, const double* v) { m.cusp = v[0]; }},
    {"FEDRAT", 1, Rule::kPositive, [](Machining& m, const double* v) { m.feed = v[0]; }},
    {"SPINDL", 1, Rule::kPositive, [](Machining& m, const double* v) { m.spindle = v[0]; }},
    {"CLEAR", 1, Rule::kAny, [](Machining& m, const double* v) { m.clearance = v[0]; }},
};

// What is wrong with the numbers of a statement, and in which field; empty where nothing is.
std::string fault_of(const StatementKind& kind, const double* v, std::size_t& field) {
  const std::string keyword(kind.keyword);
  field = 1;
  switch (kind.rule) {
    case Rule::kRange:
      field = 2;
      return v[1] > v[0] ? std::string()
                         : keyword + " is empty: its end must be greater than its start (got " +
                               number_text(v[0]) + " to " + number_text(v[1]) + ')';
    case Rule::kPositive:
      return v[0] > 0 ? std::string()
                      : keyword + " must be greater than 0 (got " + number_text(v[0]) + ')';
    case Rule::kNotNegative:
      return v[0] >= 0 ? std::string()
                       : keyword + " must not be negative (got " + number_text(v[0]) + ')';
    case Rule::kCutter:
      if (v[0] <= 0) {
        return "the cutter's diameter must be greater than 0 (got " + number_text(v[0]) + ')';
      }
      field = 2;
      return v[1] >= 0 && v[1] <= v[0] / 2
                 ? std::string()
                 : "the cutter's corner radius must be from 0 to half the diameter, " +
                       number_text(v[0] / 2) + " (got " + number_text(v[1]) + ')';
    case Rule::kAny:
      break;
  }
  return {};
}

// Plan box of what the domain follows from where it is not stated; empty (low > high) where there
// is nothing.
struct Extent {
  double low[2] = {std::numeric_limits<double>::infinity(),
                   std::numeric_limits<double>::infinity()};
  double high[2] = {-std::numeric_limits<double>::infinity(),
                    -std::numeric_limits<double>::infinity()};

  void add(const Vec3& p) {
    for (int k = 0; k < 2; ++k) {
      low[k] = std::min(low[k], p[k]);
      high[k] = std::max(high[k], p[k]);
    }
  }
};

Extent natural_extent(const PartProgram& program) {
  Extent extent;
  if (const FergusonBase* base = std::get_if<FergusonBase>(&program.base)) {
    for (const Vec3& point : base->points) extent.add(point);
    return extent;
  }
  for (const BooleanStep& step : program.boole) {
    if (step.kind != BooleanStep::Kind::kTerm || step.surface == 0) continue;
    const std::array<Vec3, 2> box =
        bounds_of(program.solids[static_cast<std::size_t>(step.surface - 1)].body);
    extent.add(box[0]);
    extent.add(box[1]);
  }
  return extent;
}

}  // namespace

double grid_line_count(const std::array<double, 2>& range, double interval) {
  return std::ceil((range[1] - range[0]) / interval * (1 - 1e-12)) + 1;
}

MachiningSection read_machining(const Section& section, LengthUnit unit, Report& report) {
  MachiningSection read;
  read.machining.tolerance = unit == LengthUnit::kInch ? 0.01 / 25.4 : 0.01;
  std::vector<std::string_view> keywords;
  for (const StatementKind& kind : kStatements) keywords.push_back(kind.keyword);
  for (const Statement* s : section.statements) {
    const std::string keyword = upper_case(s->fields[0].text);
    const auto kind = std::ranges::find(kStatements, keyword, &StatementKind::keyword);
    if (kind == std::end(kStatements)) {
      const std::string meant = suggestion(keyword, keywords);
      report.error(*s, s->column,
                   "unknown statement " + quoted(s->fields[0].text) +
                       (meant.empty() ? "; MACHI-DEF takes " + word_list(keywords) : meant));
      continue;
    }
    if (const auto [first, is_new] = read.stated.try_emplace(kind->keyword, s); !is_new) {
      report.error(*s, s->column,
                   keyword + " was already given at line " + std::to_string(first->second->line));
      continue;
    }
    double values[2] = {0, 0};
    if (!read_numbers(*s, 1, kind->numbers, true, keyword, values, report)) continue;
    std::size_t field = 1;
    const std::string fault = fault_of(*kind, values, field);
    if (!fault.empty()) {
      report.error(*s, s->fields[field], fault);
      continue;
    }
    kind->store(read.machining, values);
  }
  if (read.machining.intol == 0.0 && read.machining.outtol == 0.0) {
    const Statement& s = *read.stated.at("OUTTOL");
    report.error(s, s.fields[1], "INTOL and OUTTOL must not both be 0");
  }
  return read;
}

void resolve_domain(PartProgram& program, const MachiningSection& read, const Statement& end,
                    Report& report) {
  Machining& m = program.machining;
  const auto stated = [&](std::string_view keyword) -> const Statement* {
    const auto found = read.stated.find(keyword);
    return found == read.stated.end() ? nullptr : found->second;
  };
  std::array<double, 2>* ranges[2] = {&m.x_range, &m.y_range};
  constexpr std::string_view kRanges[2] = {"X-RNG", "Y-RNG"};
  const bool both = stated("X-RNG") != nullptr && stated("Y-RNG") != nullptr;
  if (!both) {
    if (std::holds_alternative<MeshBase>(program.base)) {
      // The scan is not read here; whoever reads it fills in what is left at zero.
      return;
    }
    const Extent extent = natural_extent(program);
    for (int k = 0; k < 2; ++k) {
      if (stated(kRanges[k]) != nullptr) continue;
      if (!(extent.low[k] < extent.high[k])) {
        report.error(end, end.column,
                     "a plane alone has no extent: the domain needs X-RNG and Y-RNG in MACHI-DEF");
        return;
      }
      *ranges[k] = {extent.low[k], extent.high[k]};
    }
  }
  const double side = std::max(m.x_range[1] - m.x_range[0], m.y_range[1] - m.y_range[0]);
  if (stated("X-INT") == nullptr) m.x_interval = side / 100;
  if (stated("Y-INT") == nullptr) m.y_interval = side / 100;
  const double points =
      grid_line_count(m.x_range, m.x_interval) * grid_line_count(m.y_range, m.y_interval);
  if (points > kMaxGridPoints) {
    const Statement* at = stated("X-INT");
    if (at == nullptr) at = stated("Y-INT");
    if (at == nullptr) at = stated("X-RNG");
    if (at == nullptr) at = &end;
    report.error(*at, at->column,
                 "the spacing gives a grid of " +
                     number_text(grid_line_count(m.x_range, m.x_interval)) + " x " +
                     number_text(grid_line_count(m.y_range, m.y_interval)) +
                     " points; the limit is 100 million",
                 ErrorCode::kLimit);
  }
}

}  // namespace diesink
