// The triangulated regions joined into one mesh: shared vertices, walls at jumps, skirts, floor,
// curves, normals. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/tessellate/arc_samples.h"
#include "core/tessellate/region_mesh.h"
#include "core/tessellate/tessellate.h"

namespace diesink {

// Errors: kInput where a floor is asked for that is not below the surface.
Result<Tessellation> assemble(const CompoundSurface& surface, const Arrangement& arrangement,
                              const ArcSamples& samples, const std::vector<RegionMesh>& regions,
                              const TessellationOptions& options);

// What a tile without a surface is.
Tessellation empty_tile(const PlanBox& box);

}  // namespace diesink
