// From a mesh with shared positions to the vertex lists that glTF primitives need.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/mesh.h"
#include "core/result.h"

namespace diesink {

// The triangles of one surface element and the run of vertices they use.
struct SplitPrimitive {
  std::uint32_t element =
      MeshCurve::kNoElement;  // index into elements; kNoElement: mesh without any
  std::uint32_t first_vertex = 0, vertex_count = 0;
  std::size_t first_triangle = 0, triangle_count = 0;
  // Vertex v is position (and normal) first_vertex + v of the mesh itself, and the triangles are
  // the mesh's own from first_triangle on, their numbers counted from the mesh's first position:
  // nothing of the primitive is in the lists of SplitMesh.
  bool as_given = false;
};

// Shape: position (and normal, where normals were asked for) have one entry a vertex; triangles
//        hold vertex numbers counted from the primitive's first vertex. Elements without triangles
//        have no primitive; the order of elements, and of triangles within one, is the mesh's.
struct SplitMesh {
  std::vector<SplitPrimitive> primitives;
  std::vector<std::uint32_t> position;  // index into mesh.positions
  std::vector<std::uint32_t> normal;    // index into mesh.normals; empty without normals
  std::unique_ptr<std::array<std::uint32_t, 3>[]> triangles;  // null where all are as given
  std::size_t used_positions = 0;  // of the mesh's, by some triangle in the lists
};

// Corners of one element that agree in position and normal share a vertex; vertices come in order
// of first use. With `runs` an element whose vertices are a run of the mesh's stays as it is
// (as_given). Errors: kInput where an index of the mesh is out of range or an array has the wrong
// length.
Result<SplitMesh> split_by_element(const TriangleMesh& mesh, bool with_normals, bool runs = false);

}  // namespace diesink
