// A mesh that OpenMesh holds, as ours: its polygons are triangles.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <array>
#include <cstdint>

#include "core/mesh.h"

namespace diesink::test {

using OtherMesh = OpenMesh::TriMesh_ArrayKernelT<OpenMesh::DefaultTraitsDouble>;

inline TriangleMesh taken_from(const OtherMesh& other) {
  TriangleMesh mesh;
  for (const auto v : other.vertices()) {
    const auto& p = other.point(v);
    mesh.positions.emplace_back(p[0], p[1], p[2]);
  }
  for (const auto f : other.faces()) {
    std::array<std::uint32_t, 3> corners{};
    std::size_t at = 0;
    for (auto v = other.cfv_iter(f); v.is_valid() && at < 3; ++v) {
      corners[at++] = static_cast<std::uint32_t>(v->idx());
    }
    mesh.triangles.push_back(corners);
  }
  return mesh;
}

}  // namespace diesink::test
