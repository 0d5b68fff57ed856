// Curves of a mesh drawn where they can be seen.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/mesh.h"
#include "picture/camera.h"
#include "picture/canvas.h"
#include "picture/film.h"

namespace diesink {

// Draws creases thin, edges and jumps stronger; a stretch behind what the film has seen is left
// out. `curves` index the positions of `mesh`. Needs: `film` seen by `camera`.
void draw_curves(const TriangleMesh& mesh, std::span<const MeshCurve> curves, const Camera& camera,
                 const Film& film, Canvas& canvas);

}  // namespace diesink
