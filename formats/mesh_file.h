// A mesh file by its name: what the command line reads and writes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "formats/format.h"
#include "formats/input_file.h"
#include "formats/output_file.h"

namespace diesink {

struct MeshFile {
  TriangleMesh mesh;
  const Format* format = nullptr;
};

// Reads the file at `path` ("-" is stdin), told by its content first, then by its ending. Fills in
// options.file_name and, unless it is stdin, options.folder.
// Errors: kInput, kLimit, kUnsupported, with the place; memory that runs out is kLimit. Warnings go
// to `diagnostics`.
Result<MeshFile> read_mesh_file(const std::string& path, ReadOptions options,
                                Diagnostics& diagnostics, std::size_t max_bytes = kMaxFileBytes);

// The size of a file that read_mesh_pieces() reads without holding it in memory, a binary STL of
// max_bytes at most; 0 of any other, and of what is no regular file.
std::size_t bytes_in_pieces(const std::string& path, std::size_t max_bytes);
Result<MeshFile> read_mesh_pieces(const std::string& path, ReadOptions options,
                                  Diagnostics& diagnostics);

// The same for the content of `path`, read before.
Result<MeshFile> read_mesh_bytes(std::span<const std::byte> bytes, const std::string& path,
                                 ReadOptions options, Diagnostics& diagnostics);

// Writes `mesh` in the format of the ending of `path` into `files`, to appear with files.commit().
// "-" needs `format`. Fills in options.file_stem, empty for stdout and devices. The answer's
// `files` is empty. Errors: kUsage for an unknown ending, kOutput, kUnsupported.
Result<WrittenMesh> write_mesh_file(const std::string& path, const TriangleMesh& mesh,
                                    WriteOptions options, OutputFiles& files,
                                    const Format* format = nullptr);

// ".stl, .obj, ..." of the formats that can be read, or written, for messages.
std::string endings_of_formats(bool written);

}  // namespace diesink
