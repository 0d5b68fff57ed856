// The compound surface over a domain with a margin: material around the domain counts for a cutter
// in it. SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/compound/compound_surface.h"

namespace diesink {

// The same surface, its domain wider by `margin` on every side as far as there is base or solid.
// Errors: as CompoundSurface::make.
Result<CompoundSurface> widened(const CompoundSurface& surface, double margin);

}  // namespace diesink
