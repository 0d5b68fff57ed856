// Which triangles of an export share a group, material or primitive in the files.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "core/mesh.h"

namespace diesink {

enum class MeshGroups : std::uint8_t { kElement, kSolid, kNone };

// Joins the elements of one solid (kSolid) or all of them (kNone, named after the mesh); triangles
// and curves keep their order and geometry, kElement changes nothing.
void group_triangles(TriangleMesh& mesh, MeshGroups groups);

}  // namespace diesink
