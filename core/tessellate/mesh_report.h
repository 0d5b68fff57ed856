// What a finished mesh says of itself.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <vector>

#include "core/tessellate/arc_samples.h"
#include "core/tessellate/region_mesh.h"
#include "core/tessellate/tessellate.h"

namespace diesink {

// Areas, volume, bounds and per-element figures of a mesh made by assemble() or the plain grid.
void fill_report(const CompoundSurface& surface, const Tessellation& tessellation, double floor,
                 TessellationReport& report);

// What the arrangement, its arcs and the regions gave up: into uncertified_area and doubts.
// `deviation`: how far off a chord may be, to either side, whose bound could not be shown.
void add_doubts(const CompoundSurface& surface, const Arrangement& arrangement,
                const ArcSamples& samples, const std::vector<RegionMesh>& regions, double deviation,
                TessellationReport& report);

inline double seconds_since(const std::chrono::steady_clock::time_point& start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace diesink
