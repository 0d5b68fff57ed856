// SPDX-License-Identifier: Apache-2.0
#include "formats/ply.h"
#include "formats/text_scanner.h"

namespace diesink {

bool looks_like_ply(std::span<const std::byte> bytes) { return first_word_of(bytes) == "ply"; }

}  // namespace diesink
