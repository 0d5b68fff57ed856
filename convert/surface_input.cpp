// From part programs on the command line to surfaces.
// SPDX-License-Identifier: Apache-2.0
#include "convert/input.h"

namespace diesink {

Loaded<CompoundSurface> make_surface(const PartProgram& program) {
  Result<CompoundSurface> surface = CompoundSurface::make(program);
  if (!surface) return {std::nullopt, report(surface.error())};
  return {std::move(*surface), ExitStatus::kDone};
}

Loaded<CompoundSurface> load_surface(const std::string& path) {
  Diagnostics diagnostics;
  const Loaded<PartProgram> program = load_part_program(path, diagnostics);
  if (!program.value) return {std::nullopt, program.status};
  return make_surface(*program.value);
}

}  // namespace diesink
