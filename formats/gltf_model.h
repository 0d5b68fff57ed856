// A glTF file after parsing and checking: what the mesh is read from.
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Debian's libdraco exports an old tinygltf of its own: ours is compiled under another name, and
// never linked.
#define tinygltf diesink_tinygltf
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_FS
#include <tiny_gltf.h>
#undef tinygltf

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/mesh.h"
#include "formats/format.h"
#include "formats/gltf_root.h"

namespace diesink {

// KHR_draco_mesh_compression of one primitive.
struct GltfDraco {
  int view = -1;
  std::map<std::string, std::uint32_t> attributes;  // name to the stream's unique id
};

// EXT_meshopt_compression of one view.
struct GltfMeshopt {
  int buffer = -1;
  std::size_t offset = 0, length = 0, stride = 0, count = 0;
  std::string mode, filter;
};

// What our own writer says of a curve.
struct GltfCurve {
  CurveKind kind = CurveKind::kOther;
  std::array<std::uint32_t, 2> between{MeshCurve::kNoElement, MeshCurve::kNoElement};
  std::size_t vertices = 0;
  bool closed = false;
  std::string name;
};

struct GltfPrimitiveExtras {
  std::optional<GltfDraco> draco;
  std::vector<GltfCurve> curves;
};

struct GltfMaterialExtras {
  bool ours = false;     // then the element is named after the material
  bool palette = false;  // the colour is the writer's, not the element's
  bool colored = false;  // baseColorFactor is given
  std::string solid;
};

struct GltfNodeExtras {
  std::optional<RootFrame> frame;
  bool unnamed = false;
};

// A buffer's bytes: part of the file, or read or decoded into `owned`.
struct GltfBuffer {
  std::span<const std::byte> bytes;
  std::vector<std::byte> owned;
  bool missing = false;  // a fallback that meshopt compression stands in for
};

struct GltfModel {
  diesink_tinygltf::Model file;
  // Beside file.meshes[m].primitives[p], file.materials, file.nodes, file.bufferViews,
  // file.accessors.
  std::vector<std::vector<GltfPrimitiveExtras>> primitives;
  std::vector<GltfMaterialExtras> materials;
  std::vector<GltfNodeExtras> nodes;
  std::vector<std::optional<GltfMeshopt>> meshopt;
  std::vector<bool> without_view;  // accessors whose values are zeros, sparse ones apart
  std::vector<GltfBuffer> buffers;
  std::vector<int> roots;  // nodes of the scene that is read
};

// Parses and checks a file: types, ranges, references, that every accessor lies in its view and
// every view in its buffer, that nodes form trees, versions and required extensions. Buffers are
// resolved. Errors: kInput or kLimit, naming the JSON value at fault.
Result<GltfModel> load_gltf(std::span<const std::byte> bytes, const ReadOptions& options,
                            Diagnostics& diagnostics);

}  // namespace diesink
