// The JSON of a glTF file, within limits that keep a hostile file cheap.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "core/diagnostics.h"
#include "core/result.h"

namespace diesink {

inline constexpr int kMaxJsonDepth = 64;
inline constexpr std::size_t kMaxJsonBytes = std::size_t{64} << 20;

// Parses one JSON object. `file_bytes` is the size of the whole file: a large one may hold more
// values. Errors: kInput with the byte where the text is no JSON (RFC 8259, UTF-8), is nested
// deeper than kMaxJsonDepth or
//         is no object; kLimit above kMaxJsonBytes or above 200,000 values and one more for each 10
//         bytes.
Result<nlohmann::json> parse_gltf_json(std::string_view text, std::size_t file_bytes,
                                       const std::string& file, Diagnostics& diagnostics);

}  // namespace diesink
