// Holes of a scan closed by smooth patches: FILL,size.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/vec.h"

namespace diesink {

struct ScanFill {
  std::size_t holes = 0;      // closed
  std::size_t triangles = 0;  // of the patches, at the end of the list
  double area = 0;            // of the patches, in plan
};

// Closes the holes that are at most `size` across in plan: no two points of their border lie
// farther apart. Islands in a hole stay, the patch goes round them. The outer border, larger holes
// and those whose borders cross in plan stay as they are. A patch shares its border's vertices;
// inside, its vertices are about as dense as on the border, and its heights bend as little as can
// be while they go on with the scan's slopes around: a plane is gone on with exactly, a sphere
// nearly. New vertices and triangles, which face up, come after the given ones. Needs:  positions
// within the coordinate limit. Source: Botsch and Kobbelt, An intuitive framework for real-time
// freeform modeling, 2004 (minimal
//         bending with the cotangent Laplacian), here for heights over the plan.
ScanFill fill_holes(std::vector<Vec3>& positions,
                    std::vector<std::array<std::uint32_t, 3>>& triangles, double size);

}  // namespace diesink
