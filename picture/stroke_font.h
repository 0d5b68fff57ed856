// Lettering as strokes, at any size.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>
#include <vector>

#include "core/vec.h"

namespace diesink {

using Stroke = std::vector<Vec2>;  // a polyline in pixels, y down

// Width in pixels of printable ASCII text whose capitals are `height` pixels tall.
double text_width(std::string_view text, double height);

// The strokes of a line of text that begins at `at` on its base line. A byte that is not printable
// ASCII is drawn as a question mark.
std::vector<Stroke> text_strokes(std::string_view text, const Vec2& at, double height);

}  // namespace diesink
