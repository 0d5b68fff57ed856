// What the PLY reader and writer share.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "formats/format.h"

namespace diesink {

bool looks_like_ply(std::span<const std::byte> bytes);

// ASCII and both byte orders, properties of any name, type and order. What this program writes
// beyond the common names: `int element` of a face, `element normal` with the faces'
// `normal1` to `normal3` (or a list `normal_indices`) where corners of one vertex have different
// normals, `int curve` of an edge, and names, colours, units and up axis in comments.
Result<TriangleMesh> read_ply(std::span<const std::byte> bytes, const ReadOptions& options,
                              Diagnostics& diagnostics);

}  // namespace diesink
