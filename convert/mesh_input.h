// Mesh files of the command line: the options that bound their reading, and the reading.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "convert/command.h"
#include "convert/input.h"
#include "formats/mesh_file.h"

namespace CLI {
class App;
}

namespace diesink {

struct MeshInputOptions {
  std::optional<int> max_memory, max_triangles;  // MiB, millions
};
void add_mesh_input_options(CLI::App& app, MeshInputOptions& options);

// Reads a mesh ("-" is stdin), in no more memory than the options give it, the file's own bytes
// among it. Its warnings are told, and kept in `diagnostics`.
Loaded<MeshFile> load_mesh(const std::string& path, const MeshInputOptions& options,
                           const CommonOptions& common, Diagnostics& diagnostics);
// The same for the content of `path`, read before.
Loaded<MeshFile> load_mesh(std::span<const std::byte> bytes, const std::string& path,
                           const MeshInputOptions& options, const CommonOptions& common,
                           Diagnostics& diagnostics);
// Bytes a file and its reading may take, and bytes it may have itself.
std::size_t max_memory_of(const MeshInputOptions& options);
std::size_t max_bytes_of(const MeshInputOptions& options);

}  // namespace diesink
