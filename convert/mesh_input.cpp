// Reading meshes for the subcommands, within limits.
// SPDX-License-Identifier: Apache-2.0
#include "convert/mesh_input.h"

#include "convert/arguments.h"

namespace diesink {

void add_mesh_input_options(CLI::App& app, MeshInputOptions& options) {
  constexpr int kMost = 1 << 20;
  add_whole_number(app, "--max-memory", options.max_memory,
                   "MiB reading a file may take (default 8192)", 1, kMost);
  add_whole_number(app, "--max-triangles", options.max_triangles,
                   "millions of triangles a file may hold (default 50)", 1, kMost);
}

std::size_t max_bytes_of(const MeshInputOptions& options) {
  // The limit somebody chose is the one that counts, up or down.
  return options.max_memory ? static_cast<std::size_t>(*options.max_memory) << 20 : kMaxFileBytes;
}

Loaded<MeshFile> load_mesh(const std::string& path, const MeshInputOptions& options,
                           const CommonOptions& common, Diagnostics& diagnostics) {
  const Result<InputBytes> file = read_file(path, max_bytes_of(options));
  if (!file) return {std::nullopt, report(file.error())};
  return load_mesh(file->bytes(), path, options, common, diagnostics);
}

Loaded<MeshFile> load_mesh(std::span<const std::byte> bytes, const std::string& path,
                           const MeshInputOptions& options, const CommonOptions& common,
                           Diagnostics& diagnostics) {
  ReadOptions read;
  read.threads = common.threads;
  if (options.max_memory) read.max_memory = max_bytes_of(options);
  if (options.max_triangles) {
    read.max_triangles = static_cast<std::size_t>(*options.max_triangles) * 1'000'000;
  }
  Result<MeshFile> file = [&] {
    const Progress progress("reading " + path, common.quiet);
    return read_mesh_bytes(bytes, path, read, diagnostics);
  }();
  const ExitStatus told = report(diagnostics);
  if (!file) return {std::nullopt, report(file.error())};
  if (told != ExitStatus::kDone) return {std::nullopt, told};
  return {std::move(*file), ExitStatus::kDone};
}

}  // namespace diesink
