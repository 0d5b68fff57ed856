// Units, up axis and title, where a format holds them as words.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "core/mesh.h"

namespace diesink {

// "mm", "cm", "m", "inch" and their long forms; kUnknown for others.
LengthUnit unit_of(std::string_view word);

// Takes "units: mm", "up: z" or "name: fig6" (the colon may be missing) from a comment's text.
void read_mark(std::string_view comment, TriangleMesh& mesh);

}  // namespace diesink
