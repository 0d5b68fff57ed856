// Reads glTF and GLB.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "formats/format.h"

namespace diesink {

// The triangles and lines of the default scene, node transforms applied. A single root node with a
// unit's scale, as our writer makes it, is undone: the mesh is then in the program's unit, axes and
// coordinates. Other files come in metres, Y up. Elements are the primitives, named after our
// writer's materials or else after node and material. Understands strips, fans, interleaved and
// sparse accessors, embedded buffers and those in files below options.folder,
// KHR_draco_mesh_compression, KHR_mesh_quantization and EXT_meshopt_compression. Errors: kInput for
// a file that breaks glTF's rules where it matters for the mesh; kLimit where it claims more than
//         options allow, or than 500,000 vertices or triangles and 64 more for each byte of it and
//         its buffers. What is not kept (textures, animations, unknown extensions) is told in
//         warnings.
Result<TriangleMesh> read_gltf(std::span<const std::byte> bytes, const ReadOptions& options,
                               Diagnostics& diagnostics);

}  // namespace diesink
