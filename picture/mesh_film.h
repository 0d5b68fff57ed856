// A view of a mesh: rasterized with a depth buffer.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/mesh.h"
#include "picture/camera.h"
#include "picture/film.h"
#include "picture/paint.h"

namespace diesink {

// Every triangle is seen from both sides, smooth where the mesh has normals. Of triangles at one
// depth the first is seen. The same film for any number of threads.
// Needs: a mesh whose indices are valid, z up; a palette that has its elements.
void film_mesh(const TriangleMesh& mesh, const Camera& camera, const Paint& paint, int threads,
               Film& film);

}  // namespace diesink
