// The compound surface over a domain with a margin: material around the domain counts for a cutter
// in it. SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/compound/compound_surface.h"
#include "core/tessellate/tessellate.h"

namespace diesink {

// The same surface, its domain wider by `margin` on every side as far as there is base or solid.
// Errors: as CompoundSurface::make.
Result<CompoundSurface> widened(const CompoundSurface& surface, double margin);

// How far a mesh may be from the surface outside its uncertified_area: at a place of that it may be
// further off than any tolerance, which says nothing of the rest.
double deviation_where_certified(const TessellationReport& report);

}  // namespace diesink
