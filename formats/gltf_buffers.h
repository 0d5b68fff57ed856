// The bytes of a glTF file's buffers: the GLB's own, in the text, or in a file beside it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "formats/gltf_model.h"
#include "formats/gltf_reduce.h"

namespace diesink {

// Shape:  one a source, each of exactly the length the source claims.
// Errors: kInput where bytes are missing, the URI is no file name below options.folder (no scheme,
// no absolute path, no
//         "..", no link out of it), the file is not regular or is the glTF file itself; kLimit
//         above 2 GiB.
Result<std::vector<GltfBuffer>> resolve_buffers(const std::vector<GltfBufferSource>& sources,
                                                std::span<const std::byte> glb_buffer,
                                                bool has_glb_buffer, const ReadOptions& options,
                                                Diagnostics& diagnostics);

}  // namespace diesink
