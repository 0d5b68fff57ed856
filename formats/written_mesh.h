// The in-memory form of a streaming writer.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "formats/format.h"

namespace diesink {

// Runs `stream` into memory: the `write` of a format that has `stream`.
Result<WrittenMesh> write_to_memory(decltype(Format::stream) stream, const TriangleMesh& mesh,
                                    const WriteOptions& options);

}  // namespace diesink
