// The in-memory form of a streaming writer.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "formats/format.h"

namespace diesink {

// Runs `stream` into memory.
Result<WrittenMesh> write_to_memory(decltype(Format::stream) stream, const TriangleMesh& mesh,
                                    const WriteOptions& options);

// The same as the `write` of a format that has `stream`.
template <auto kStream>
Result<WrittenMesh> write_to_memory(const TriangleMesh& mesh, const WriteOptions& options) {
  return write_to_memory(kStream, mesh, options);
}

}  // namespace diesink
