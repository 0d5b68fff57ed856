// Passes along the feet of upright walls: where the passes of a family meet a wall at a slant, or
// pass it by, they leave ridges on it that no interval cures.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "core/machining/segment_profile.h"
#include "core/mesh.h"

namespace diesink {

struct WallRunOptions {
  double below = 0, above = 0;  // as fit_runs
  double chord = 0;
  double least_depth = 0;      // of a wall below the cutter's corner, to be worth a pass
  std::array<Vec2, 4> domain;  // of the centre, in the frame, anticlockwise
};

// The tips of runs that keep the cutter's side against the walls of the mesh, in the frame of
// `offset`, in the order of the walls. A wall is told by its upright triangles; where the surface
// just ends, that counts as one. What the cutter cannot get down to beside it is left out.
// Bound: moves keep `below` and `above` to the lowest safe height over their whole length; their
// distance from the wall exceeds the cutter's radius by less than `above`.
std::vector<std::vector<Vec3>> wall_runs(const TriangleMesh& mesh, const OffsetSurface& offset,
                                         const PointDrop& drop, const WallRunOptions& options);

}  // namespace diesink
