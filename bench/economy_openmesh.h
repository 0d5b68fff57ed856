// The mesh of OpenMesh that both comparisons decimate.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModNormalFlippingT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>

namespace diesink::bench {

struct DoublePoints : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
};
using Mesh = OpenMesh::TriMesh_ArrayKernelT<DoublePoints>;

// Those that a decimater has left, by the numbers of their vertices before it.
inline std::vector<std::array<std::uint32_t, 3>> triangles_left(const Mesh& mesh) {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  for (const auto f : mesh.faces()) {
    if (f.deleted()) continue;
    std::array<std::uint32_t, 3> t{};
    std::size_t n = 0;
    for (auto fv = mesh.cfv_iter(f); fv.is_valid(); ++fv)
      t[n++] = static_cast<std::uint32_t>(fv->idx());
    triangles.push_back(t);
  }
  return triangles;
}

}  // namespace diesink::bench
