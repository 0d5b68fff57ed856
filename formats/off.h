// What the OFF reader and writer share.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "formats/format.h"

namespace diesink {

bool looks_like_off(std::span<const std::byte> bytes);

// OFF, COFF, NOFF, CNOFF and ST forms in ASCII; colours of faces become elements. Binary, 4D and nD
// are refused.
Result<TriangleMesh> read_off(std::span<const std::byte> bytes, const ReadOptions& options,
                              Diagnostics& diagnostics);

}  // namespace diesink
