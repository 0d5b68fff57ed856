// Plan points from a CSV, for `cc --at`.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/diagnostics.h"
#include "core/vec.h"

namespace diesink {

// Reads `x,y` lines. A first line with words for a header names the columns: x and y are taken from
// theirs, others are passed over; without one every line has two fields. Blank lines and what
// follows a # mean nothing; LF and CRLF both end a line; a UTF-8 byte order mark is skipped.
// Errors: with line and column, at most 20 of them; the points are complete only where there are
//         none. Coordinates beyond 1e9 are refused. Never throws for bad data.
std::vector<Vec2> read_csv_points(std::string_view text, const std::string& file_name,
                                  Diagnostics& diagnostics);

}  // namespace diesink
