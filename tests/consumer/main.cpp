// What a project that uses diesink does first: a plane with a ball on it, asked for its height.
// SPDX-License-Identifier: Apache-2.0
#include <core/compound/compound_surface.h>
#include <core/part_program/part_program.h>
#include <formats/format.h>

#include <cmath>
#include <cstdio>
#include <optional>

int main() {
  constexpr std::string_view kProgram =
      "SOLID-DEF\nS1,SPHER,1\nP1,5,5,0\nRAD,3\n"
      "BSURF-DEF\nPLANE,0\n"
      "BOOLE-DEF\nB+S1\n"
      "MACHI-DEF\nX-RNG,0,10\nY-RNG,0,10\n";
  diesink::Diagnostics diagnostics;
  const std::optional<diesink::PartProgram> program =
      diesink::parse_part_program(kProgram, "ball.part", diagnostics);
  if (!program) {
    for (const diesink::Diagnostic& each : diagnostics.all()) {
      std::fprintf(stderr, "%s\n", diesink::to_text(each).c_str());
    }
    return 1;
  }
  const diesink::Result<diesink::CompoundSurface> surface = diesink::CompoundSurface::make(*program);
  if (!surface) return 1;
  const std::optional<diesink::CcDatum> top = surface->at(5, 5);
  if (!top || std::abs(top->z - 3) > 1e-12) return 1;
  std::printf("top %g on %s, %zu formats\n", top->z, program->solids[0].id.c_str(),
              diesink::all_formats().size());
  return diesink::format_of_ending("die.stl") == nullptr ? 1 : 0;
}
