// Meshes on their way into files: the options export and convert share, and the writing itself.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/mesh.h"
#include "core/result.h"
#include "formats/format.h"

namespace CLI {
class App;
}

namespace diesink {

class OutputFiles;

struct MeshOutputOptions {
  bool ascii = false;
  bool draco = false;
  std::optional<int> draco_speed;
  std::optional<int> quantize_bits;
};
void add_mesh_output_options(CLI::App& app, MeshOutputOptions& options);
// --format: what goes to stdout for an output "-".
void add_stdout_format(CLI::App& app, std::string& format);

// One file to be written.
struct MeshTarget {
  std::string path;  // "-" is stdout
  const Format* format = nullptr;
};

// The formats of the paths by their endings; `stdout_format` is the one of "-".
// Errors: kUsage for an ending nobody writes, a path given twice, a format that cannot go to stdout
// as text,
//         an option none of the formats has; kOutput where the folder of a path is not there.
Result<std::vector<MeshTarget>> mesh_targets(const std::vector<std::string>& paths,
                                             std::string_view stdout_format,
                                             const MeshOutputOptions& options);

// Writes the mesh to one target of `files`; nothing appears before files.commit().
// write.program_comment, ascii, draco and what belongs to it are filled in from `options`.
Result<WrittenMesh> write_mesh(OutputFiles& files, const MeshTarget& target,
                               const TriangleMesh& mesh, const MeshOutputOptions& options,
                               WriteOptions write);

// One line for each thing the mesh holds that the format does not: "STL keeps no lines".
std::vector<std::string> lost_in(const MeshTarget& target, const TriangleMesh& mesh,
                                 const MeshOutputOptions& options);

// What the target's format must say and the mesh does not: which unit and up axis are assumed.
std::vector<std::string> assumed_in(const MeshTarget& target, const TriangleMesh& mesh);

}  // namespace diesink
