// What there is to say of a scanned base: how it covers the domain, what FILL closed.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "core/base/scan_fill.h"
#include "core/base/scan_sheet.h"
#include "core/compound/compound_surface.h"
#include "formats/json_writer.h"

namespace diesink {

struct ScanFigures {
  ScanCover cover;
  ScanFill fill;
  bool filled = false;  // the program asks for it
};

// Of the surface's domain; empty where its base is no scan.
std::optional<ScanFigures> scan_figures(const CompoundSurface& surface, int threads);

// "scan": {"open_area", "holes", "layered_area", "crease_offset", "filled_holes", "filled_area"},
// the last two with FILL, crease_offset (TessellationReport) where there is a mesh.
void write_scan(JsonWriter& json, const ScanFigures& scan,
                std::optional<double> crease_offset = std::nullopt);

// One line for people.
std::string scan_text(const ScanFigures& scan);

}  // namespace diesink
