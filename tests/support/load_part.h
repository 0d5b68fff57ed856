// Part programs of the tests as compound surfaces.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fstream>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <string>

#include "core/compound/compound_surface.h"
#include "core/part_program/part_program.h"

namespace diesink::test {

// Throws with the messages where the text is no valid part program: a test's own mistake.
inline PartProgram program_of(const std::string& text, const std::string& name = "test.part") {
  Diagnostics diagnostics;
  std::optional<PartProgram> program = parse_part_program(text, name, diagnostics);
  if (program) return *std::move(program);
  std::string messages;
  for (const Diagnostic& d : diagnostics.all()) messages += to_text(d) + '\n';
  throw std::runtime_error(messages + text);
}

inline CompoundSurface surface_of(const std::string& text, const std::string& name = "test.part") {
  Result<CompoundSurface> surface = CompoundSurface::make(program_of(text, name));
  if (!surface) throw std::runtime_error(to_text(surface.error()));
  return std::move(*surface);
}

// The text of fixtures/parts/NAME.part.
inline std::string part_text(const std::string& name) {
  std::ifstream file(std::string(DIESINK_SOURCE_DIR) + "/fixtures/parts/" + name + ".part",
                     std::ios::binary);
  if (!file) throw std::runtime_error("no fixtures/parts/" + name + ".part");
  return {std::istreambuf_iterator<char>(file), {}};
}

inline CompoundSurface fixture(const std::string& name) {
  return surface_of(part_text(name), name + ".part");
}

}  // namespace diesink::test
