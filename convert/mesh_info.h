// What a mesh is made of, for people and as JSON.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "core/diagnostics.h"
#include "core/mesh_tools/crossings.h"
#include "core/mesh_tools/topology.h"
#include "formats/mesh_file.h"

namespace diesink {

// `crossings`: null where nobody looked for any.
std::string mesh_info(const MeshFile& file, const MeshTopology& topology,
                      const MeshCrossings* crossings = nullptr);

// {"format","vertices","triangles","lines","shells","boundary_loops","nonmanifold_edges","watertight","area","volume",
// "bounds","units","up","names", ...}; counts after exact welding.
std::string mesh_info_json(const MeshFile& file, const MeshTopology& topology,
                           const Diagnostics& diagnostics,
                           const MeshCrossings* crossings = nullptr);

}  // namespace diesink
