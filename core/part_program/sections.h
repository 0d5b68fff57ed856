// The sections of a part program, each read by one function of its own file.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/part_program/part_program.h"
#include "core/part_program/report.h"
#include "core/part_program/statement.h"

namespace diesink {

using StatementList = std::vector<const Statement*>;

// A section as it stands in the text.
struct Section {
  const Statement* header = nullptr;
  StatementList statements;
};

// Every ID a header names, in error or not, so that one mistake does not bring others.
struct SolidNames {
  std::map<std::string, const Statement*, std::less<>> declared;
  std::map<std::string, int, std::less<>> surface;  // number k of solids[k-1], of the good ones
  std::map<int, const Statement*> header;           // by surface number
};

struct MachiningSection {
  Machining machining;
  // Where a statement stood, by keyword; for messages about what they say together.
  std::map<std::string_view, const Statement*> stated;
};

std::vector<Solid> read_solids(const Section& section, SolidNames& names, Report& report);
BaseSurface read_base(const Section& section, Report& report);
std::vector<BooleanStep> read_expression(const Section& section, const SolidNames& names,
                                         const Section* base_section, bool has_base,
                                         Report& report);
MachiningSection read_machining(const Section& section, LengthUnit unit, Report& report);

// Fills in domain and spacing where they were not stated, and checks both.
// Needs: a program without errors so far; `end` is the statement that stands for what is missing.
void resolve_domain(PartProgram& program, const MachiningSection& read, const Statement& end,
                    Report& report);

// ---- what the section readers share ----

// Numbers of a statement after its keyword, each within kMaxCoordinate where `coordinates`.
// Tells count and form errors; `what` names the statement in messages.
bool read_numbers(const Statement& statement, std::size_t first, std::size_t count,
                  bool coordinates, std::string_view what, double* out, Report& report);

// One number of a field, with the message where it is none.
bool read_field(const Statement& statement, std::size_t index, double& value, Report& report);

// A whole number of a field in [least, most]; says `what` it should be.
bool read_count(const Statement& statement, std::size_t index, int least, int most,
                std::string_view what, int& value, Report& report);

// The index of the known word that `word`, in upper case, was probably meant to be: one that few
// edits make of it, or else the longest it begins with (RADIUS for RAD, TOLERANCE for TOLER).
std::optional<std::size_t> meant_word(std::string_view word,
                                      const std::vector<std::string_view>& known);

// `; did you mean WORD?`, or nothing.
std::string suggestion(std::string_view word, const std::vector<std::string_view>& known);

// "A, B and C".
std::string word_list(const std::vector<std::string_view>& words, std::string_view last = "and");

}  // namespace diesink
