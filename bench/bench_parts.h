// The parts that benchmarks work on.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>

#include "core/compound/compound_surface.h"
#include "core/part_program/part_program.h"

namespace diesink::bench {

// The surface of a part file; ends the program where it cannot be made, for then there is nothing
// to measure.
inline CompoundSurface load(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  Diagnostics diagnostics;
  const std::optional<PartProgram> program = parse_part_program(text, path, diagnostics);
  if (program) {
    Result<CompoundSurface> surface = CompoundSurface::make(*program);
    if (surface) return std::move(*surface);
    std::fprintf(stderr, "%s\n", to_text(surface.error()).c_str());
  }
  for (const Diagnostic& d : diagnostics.all()) std::fprintf(stderr, "%s\n", to_text(d).c_str());
  std::exit(2);
}

// One of fixtures/parts.
inline CompoundSurface fixture(const std::string& name) {
  return load(DIESINK_FIXTURE_PARTS "/" + name + ".part");
}

// One that the build generates: solidsN for 100, 400, 1600 and 6400, and
// solids400w (its base warped in plan).
inline CompoundSurface generated(const std::string& name) {
  return load(DIESINK_BENCH_PARTS "/" + name + ".part");
}

}  // namespace diesink::bench
