// Normals of a mesh that comes without them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/mesh.h"

namespace diesink {

// Fills normals and corner_normals: at each corner the mean, by angle, of the triangles around the
// vertex that belong to the same element and turn by less than `degrees` from this one. Equal
// positions count as one vertex; where over 256 corners meet each keeps its triangle's normal.
// Needs: valid indices.
void smooth_normals(TriangleMesh& mesh, double degrees);

}  // namespace diesink
