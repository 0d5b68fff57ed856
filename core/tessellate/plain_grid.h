// The grid array as a mesh, without its edge points: what the other meshes are compared with.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/base_surface.h"
#include "core/compound/compound_surface.h"
#include "core/tessellate/tessellate.h"

namespace diesink {

// Two triangles for every cell of the grid array within `box` whose four corners have a surface,
// one where only three have; each belongs to the face of the corner it has first. Walls become
// slopes and creases steps. The report certifies nothing: all of its plan area is uncertified_area.
// Errors: kUsage for a solid, which such a sheet cannot be closed into; kLimit for a grid over the
// limits.
Result<Tessellation> mesh_plain_grid(const CompoundSurface& surface, const PlanBox& box,
                                     const TessellationOptions& options);

}  // namespace diesink
