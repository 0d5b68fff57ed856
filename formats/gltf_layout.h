// What a glTF file of a mesh consists of: vertices, primitives, and where each lies in the buffer.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/mesh.h"
#include "formats/draco_mesh.h"
#include "formats/format.h"
#include "formats/gltf_root.h"
#include "formats/gltf_split.h"

namespace diesink {

class ByteWriter;

// All curves of a mesh as one set of segments.
struct GltfLines {
  std::vector<std::uint32_t> position;   // index into the mesh's positions, curve after curve
  std::vector<std::uint32_t> index;      // two a segment
  std::vector<const MeshCurve*> curves;  // those with a segment at least
};

// One kind of values, primitive after primitive; becomes a bufferView where it is not empty.
struct GltfView {
  std::size_t offset = 0, size = 0;
  std::size_t stride = 0;  // 0 for indices
};
enum GltfViewKind { kShortIndices, kLongIndices, kPositions, kNormals, kColors, kViewKinds };

struct GltfPrimitive {
  bool lines = false;
  std::uint32_t element = MeshCurve::kNoElement;
  const std::uint32_t* indices = nullptr;   // of vertices, each with `base` added
  const std::uint32_t* position = nullptr;  // index into the coordinates, one a vertex
  const std::uint32_t* normal = nullptr;    // index into the normals, one a vertex
  std::uint32_t base = 0;  // where `position` is null vertex v has position and normal base + v
  bool with_normals = false, colored = false;
  std::size_t vertex_count = 0, index_count = 0;
  std::array<float, 3> low{}, high{};  // exact bounds of the positions
  std::size_t index_at = 0, position_at = 0, normal_at = 0, color_at = 0;  // within their views
  int blob = -1;  // index into blobs, or -1

  [[nodiscard]] std::size_t position_of(std::size_t v) const {
    return position == nullptr ? base + v : position[v];
  }
  // 65535 itself restarts a primitive, so that many vertices need longer indices.
  [[nodiscard]] bool short_indices() const { return vertex_count < 65535; }
};

// Needs: the mesh it was made from outlives it.
struct GltfLayout {
  RootFrame frame;
  // With Draco: each position on its grid, less the frame's offset, and each normal, of unit length
  // (while it is compressed). Else both are made of the mesh's as they are written.
  std::vector<std::array<float, 3>> coordinates;
  std::vector<std::array<float, 3>> normals;
  bool with_normals = false;
  // Of every kBoxed positions of the mesh the lowest and the highest coordinates.
  static constexpr std::size_t kBoxed = 1024;
  std::vector<std::array<Vec3, 2>> boxes;
  SplitMesh split;
  GltfLines lines;
  std::vector<GltfPrimitive> primitives;
  std::vector<DracoBlob> blobs;  // a view each, after the others
  std::vector<std::size_t> blob_at;
  std::array<GltfView, kViewKinds> views;
  std::size_t buffer_size = 0;
  double deviation = 0;  // largest distance between a vertex and what the file holds
  std::vector<std::string> notes;
};

// Errors: kInput for a mesh with indices out of range or coordinates that are not finite or beyond
// 1e9;
//         kUsage for quantize_bits out of 1..24.
Result<GltfLayout> lay_out(const TriangleMesh& mesh, const WriteOptions& options);

// The buffer's bytes, buffer_size of them. Notes what has to be told of the normals.
void put_buffer(GltfLayout& layout, const TriangleMesh& mesh, ByteWriter& out);

}  // namespace diesink
