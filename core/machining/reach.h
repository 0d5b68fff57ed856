// Where a cutter cannot touch the surface: concave places narrower than itself.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "core/compound/compound_surface.h"
#include "core/machining/drop.h"

namespace diesink {

struct UnreachableArea {
  double area = 0;    // in plan
  double height = 0;  // the most that must stay over the surface there
};

// Examines a lattice of about `samples` points of the domain: a point is reached where the cutter,
// placed on it by equation (6), touches the mesh of `drop` no more than `tolerance` higher. What
// stays over the others is the least the cutter leaves from any of a star of positions around them:
// an upper bound of what must stay. Needs: `drop` in the program's own frame (angle 0).
UnreachableArea unreachable_area(const CompoundSurface& surface, const OffsetSurface& offset,
                                 const PointDrop& drop, const std::array<double, 4>& domain,
                                 double tolerance, std::size_t samples, int threads);

}  // namespace diesink
