// Pictures as PNG.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "formats/byte_sink.h"

namespace diesink {

// Writes a picture of 8-bit RGB pixels, top row first. The same pixels give the same bytes.
// Needs: rgb.size() == 3 * width * height, both at least 1.
// Errors: kLimit where libpng refuses the size; what the sink returns.
Status write_png(std::size_t width, std::size_t height, std::span<const std::uint8_t> rgb,
                 ByteSink& sink);

}  // namespace diesink
