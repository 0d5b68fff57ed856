// Units and up axis of a mesh, changed as the command line asks.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/mesh.h"
#include "core/result.h"

namespace diesink {

// What the command line says of a mesh's frame; empty = as the file says, or as it is.
struct MeshFrame {
  std::optional<LengthUnit> unit_in, unit_out;
  std::optional<UpAxis> up_in, up_out;
};

// Takes the file's numbers as `*_in` says, then scales and turns them to `*_out`: positions,
// normals, nothing where both are the same. Y up to Z up turns (x, y, z) into (x, -z, y).
// `warnings` gets a line where the extent makes the unit doubtful (a part over 100 m or under 0.1
// mm). Errors: kUsage where `*_out` is asked and nothing says what the file's is.
Status change_frame(TriangleMesh& mesh, const MeshFrame& frame, std::vector<std::string>& warnings);

}  // namespace diesink
