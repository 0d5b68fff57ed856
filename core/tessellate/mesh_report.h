// What a finished mesh says of itself.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/tessellate/tessellate.h"

namespace diesink {

// Areas, volume, bounds and per-element figures of a mesh made by assemble() or the plain grid.
void fill_report(const CompoundSurface& surface, const Tessellation& tessellation, double floor,
                 TessellationReport& report);

}  // namespace diesink
