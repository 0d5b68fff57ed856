// The container of a GLB file: which bytes are the JSON and which the buffer.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "core/diagnostics.h"
#include "core/result.h"

namespace diesink {

struct GlbParts {
  std::span<const std::byte> json;
  std::span<const std::byte> buffer;
  bool has_buffer = false;
};

// The size of a GLB of this much JSON, padded to four bytes, and buffer.
// Errors: kUnsupported above 4294967295 bytes, which is what its 32-bit lengths can tell; the
// message names formats that hold more.
Result<std::uint32_t> glb_size(std::uint64_t json, std::uint64_t buffer);

// Splits the file; nothing is copied.
// Errors: kInput with the byte where lengths, order, alignment or version are wrong. Bytes after
// the file's own
//         length and chunks of unknown kind are left out with a warning.
// Source: glTF 2.0, section 4.
Result<GlbParts> split_glb(std::span<const std::byte> bytes, const std::string& file,
                           Diagnostics& diagnostics);

}  // namespace diesink
