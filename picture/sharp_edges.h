// The sharp edges of a mesh that comes without curves.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/mesh.h"

namespace diesink {

// A two-point curve for every edge where surface elements meet or the normals turn by more than
// `degrees` (kCrease), and where the mesh ends (kEdge). Equal positions count as one vertex.
std::vector<MeshCurve> sharp_edges(const TriangleMesh& mesh, double degrees);

}  // namespace diesink
