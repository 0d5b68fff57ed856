// Triangles of a mesh that cross one another. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/mesh.h"

namespace diesink {

struct MeshCrossings {
  std::size_t pairs = 0;                 // of triangles that cross
  std::size_t triangles = 0;             // that cross another one
  std::array<std::uint32_t, 2> first{};  // the numbers of the first pair, in order of the numbers
  Vec3 at = Vec3::Zero();                // a place where the first pair meets, rounded
};

// Pairs of triangles that meet elsewhere than in a vertex or an edge both have, equal positions
// taken as one vertex: they go through one another, lie upon one another, or touch. Decided with
// exact signs. Repeated triangles, and those without area, are left out: topology_of() counts them.
// The same for any number of threads; the time grows with n log n, and with the pairs whose boxes
// meet.
// Needs: finite coordinates below 2^200; those nearer to 0 than 2^-200 count as 0.
// Memory: 150 bytes a triangle.
MeshCrossings find_crossings(const TriangleMesh& mesh, int threads = 0);

}  // namespace diesink
