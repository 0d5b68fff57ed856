// The JSON text of a glTF file.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "formats/gltf_layout.h"

namespace diesink {

// One root node with the matrix to metres and Y up; below it a mesh with one primitive and one
// material a surface element, both named after it, and one with the LINES primitive of all curves.
// The elements' solids, the program's unit, axis and offset, and the kinds of the curves stand in
// `extras`. `uri` names the buffer's file; empty where the buffer is the GLB's own. Errors: kUsage
// where options.extras_json is not JSON.
Result<std::string> gltf_text(const GltfLayout& layout, const TriangleMesh& mesh,
                              const WriteOptions& options, const std::string& uri);

}  // namespace diesink
