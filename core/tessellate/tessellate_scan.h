// Tessellation over a scanned base.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/tessellate/tessellate.h"

namespace diesink {

// As tessellate(), adaptive, for a surface whose base is a scan.
// Source: docs/tessellation.md, "A scanned base".
Result<Tessellation> tessellate_scan(const CompoundSurface& surface, const PlanBox& box,
                                     const TessellationOptions& options);

// The same surface over what is seen of its scan: pieces of facets, none over another, for what
// takes the base as it is; walls are strips, as far beside them as a part of the tolerance.
// Errors: kInput where nothing of the scan lies in the domain.
Result<CompoundSurface> seen_surface(const CompoundSurface& surface, const PlanBox& domain,
                                     double tolerance, int threads);

}  // namespace diesink
