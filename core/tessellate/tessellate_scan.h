// Tessellation over a scanned base.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/tessellate/tessellate.h"

namespace diesink {

// As tessellate(), adaptive, for a surface whose base is a scan.
// Source: docs/tessellation.md, "A scanned base".
Result<Tessellation> tessellate_scan(const CompoundSurface& surface, const PlanBox& box,
                                     const TessellationOptions& options);

}  // namespace diesink
