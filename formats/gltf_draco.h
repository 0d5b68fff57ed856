// Draco compression of the primitives of a glTF file.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "formats/gltf_layout.h"

namespace diesink {

// Puts the coordinates of the layout on one grid, fine enough for half of options.tolerance, and
// gives every triangle primitive a compressed blob. Vertices that were equal stay equal to the bit
// in all primitives, lines included. A primitive that Draco cannot hold stays as it is, with a
// note. layout.deviation becomes that of what was decoded again. Needs: set primitives, not yet
// placed. Errors: kUsage for quantize_bits out of 1..24.
Status compress(const TriangleMesh& mesh, const WriteOptions& options, GltfLayout& layout);

}  // namespace diesink
