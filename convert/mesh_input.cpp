// Reading meshes for the subcommands, within limits.
// SPDX-License-Identifier: Apache-2.0
#include "convert/mesh_input.h"

#include <algorithm>
#include <utility>

#include "convert/arguments.h"
#include "convert/memory_limit.h"
#include "core/parallel.h"

namespace diesink {

void add_mesh_input_options(CLI::App& app, MeshInputOptions& options) {
  constexpr int kMost = 1 << 20;
  add_whole_number(app, "--max-memory", options.max_memory,
                   "MiB a file and its reading may take (default 8192)", 1, kMost);
  add_whole_number(app, "--max-triangles", options.max_triangles,
                   "millions of triangles a file may hold (default 50)", 1, kMost);
}

std::size_t max_memory_of(const MeshInputOptions& options) {
  return options.max_memory ? static_cast<std::size_t>(*options.max_memory) << 20
                            : ReadOptions().max_memory;
}

std::size_t max_bytes_of(const MeshInputOptions& options) {
  // The limit somebody chose is the one that counts, up or down.
  return options.max_memory ? max_memory_of(options) : kMaxFileBytes;
}

namespace {

// Needs a MemoryLimit in force. `read` is given the options.
template <class Read>
Loaded<MeshFile> parse_mesh(std::size_t bytes, const std::string& path,
                            const MeshInputOptions& options, const CommonOptions& common,
                            Diagnostics& diagnostics, Read read) {
  ReadOptions limits;
  limits.threads = common.threads;
  limits.max_memory = max_memory_of(options);
  if (options.max_triangles) {
    limits.max_triangles = static_cast<std::size_t>(*options.max_triangles) * 1'000'000;
  }
  Result<MeshFile> file = [&] {
    const Progress progress("reading " + path, common.quiet, {static_cast<double>(bytes), "B"});
    const ProgressSpan span(progress.told(), 0, 1);
    return read(std::move(limits));
  }();
  const ExitStatus told = report(diagnostics);
  if (!file) return {std::nullopt, report(file.error())};
  if (told != ExitStatus::kDone) return {std::nullopt, told};
  return {std::move(*file), ExitStatus::kDone};
}

}  // namespace

Loaded<MeshFile> load_mesh(const std::string& path, const MeshInputOptions& options,
                           const CommonOptions& common, Diagnostics& diagnostics) {
  const MemoryLimit limit(max_memory_of(options));
  if (const std::size_t size = bytes_in_pieces(path, max_bytes_of(options)); size > 0) {
    return parse_mesh(size, path, options, common, diagnostics, [&](ReadOptions read) {
      return read_mesh_pieces(path, std::move(read), diagnostics);
    });
  }
  Result<InputBytes> file = read_file(path, max_bytes_of(options), common.threads);
  if (!file) {
    Error error = file.error();
    if (error.code == ErrorCode::kLimit) error.message += "; --max-memory raises it";
    return {std::nullopt, report(error)};
  }
  return parse_mesh(file->bytes().size(), path, options, common, diagnostics,
                    [&](ReadOptions read) {
                      read.done_with = [&](std::size_t count) { file->forget(count); };
                      return read_mesh_bytes(file->bytes(), path, std::move(read), diagnostics);
                    });
}

Loaded<MeshFile> load_mesh(std::span<const std::byte> bytes, const std::string& path,
                           const MeshInputOptions& options, const CommonOptions& common,
                           Diagnostics& diagnostics) {
  const std::size_t most = max_memory_of(options);
  const MemoryLimit limit(most - std::min(most, bytes.size()));
  return parse_mesh(bytes.size(), path, options, common, diagnostics, [&](ReadOptions read) {
    return read_mesh_bytes(bytes, path, std::move(read), diagnostics);
  });
}

}  // namespace diesink
