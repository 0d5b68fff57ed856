// How far the triangles of a mesh lie from a compound surface.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/compound/compound_surface.h"
#include "core/mesh.h"

namespace diesink {

// One a triangle: of the samples inside it, that which lies farthest from the surface over or under
// it, along the surface's normal, above it positive. NaN where none can be told: upright
// triangles, triangles outside the surface.
// `own`: the mesh is the surface's tessellation; samples whose vertical line meets another element
// than the triangle's, a hair beyond an edge, are left out.
// Units:  the surface's. The same for any number of threads.
std::vector<float> mesh_deviations(const TriangleMesh& mesh, const CompoundSurface& surface,
                                   bool own, int threads);

}  // namespace diesink
