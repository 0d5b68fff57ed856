// What a part program holds, for people and as JSON.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "convert/scan_figures.h"
#include "core/diagnostics.h"
#include "core/part_program/part_program.h"

namespace diesink {

// Solids, base, domain and grid, and the Boolean table: one row a term, with its ID, type and sign.
// `scan` tells of a scanned base; null without one.
std::string program_info(const PartProgram& program, const ScanFigures* scan = nullptr);

// {"solids","boole","base","domain","grid","warnings", ...}
std::string program_info_json(const PartProgram& program, const Diagnostics& diagnostics,
                              const ScanFigures* scan = nullptr);

}  // namespace diesink
