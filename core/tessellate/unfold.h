// Triangles of a region that look down or have no area, laid anew so that they look up.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/vec.h"

namespace diesink {

struct UnfoldRules {
  // Whether a triangle looks down or has no area.
  std::function<bool(std::uint32_t, std::uint32_t, std::uint32_t)> is_wrong;
  // Deviation of any other.
  std::function<double(std::uint32_t, std::uint32_t, std::uint32_t)> bound;
  double tolerance = 0;  // for the bound
};

// On a steep flank, above all near the apex of a cone, whose rulings draw together at any scale, a
// triangulation that is well-shaped on the face folds over in plan. What is wrong is dug out with
// its neighbours, and the same vertices are joined in plan, where nothing can fold; then edges are
// flipped while that lowers the bounds and all go on looking up.
// Shape:  triangles index positions, anticlockwise on the face; the set of vertices stays.
// Bound:  a patch is laid anew only if its triangles keep the tolerance or what they replace did
//         not either; what cannot be laid anew stays as it is.
void unfold(const std::vector<Vec3>& positions, const UnfoldRules& rules,
            std::vector<std::array<std::uint32_t, 3>>& triangles);

}  // namespace diesink
