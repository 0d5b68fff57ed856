// The figures of an export, as --report and --json give them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <unordered_map>

#include "convert/scan_figures.h"
#include "core/tessellate/tessellate.h"

namespace diesink {

struct ExportSeconds {
  double parse = 0, write = 0,
         total = 0;  // evaluate and tessellate stand in the tessellation's report
};

struct ExportReport {
  std::size_t triangles = 0, vertices = 0;
  TessellationReport surface;
  std::optional<ScanFigures> scan;  // of a scanned base
  ExportSeconds seconds;
  int threads = 0;
  // Places of the surface's elements by name, as add_tile() needs them.
  std::unordered_map<std::string, std::size_t> element_at;
};

// Adds one tile's figures to those of the tiles before it: sums, largest deviations, united bounds;
// elements of one name become one.
void add_tile(ExportReport& report, const Tessellation& tile, bool first);

// True where the mesh keeps what was asked: certified within the tolerance, everywhere.
bool is_kept(const TessellationReport& report);

// One JSON object. Without `run` it leaves out what differs from run to run (seconds, threads):
// that form goes into glTF files, whose bytes depend on the part program alone.
std::string to_json(const ExportReport& report, bool run);

}  // namespace diesink
