// Counts of lines, many bytes at a time, where a text is as programs write it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

#include "formats/obj_parse.h"

namespace diesink {

// The lines of a text in which every line is a row: none is empty or begins with a blank, and no
// `#` and no control character but LF is in it. Nothing where that is not so. The last line need
// not end.
std::optional<std::size_t> plain_row_count(std::string_view text);

// The statements v, vt and vn of an OBJ text that begins with a statement, where a word stands at
// the start of every line and neither a backslash nor a control character but LF is in it. Nothing
// where that is not so, or where another word begins with a v.
std::optional<ObjCounts> plain_obj_counts(std::string_view text);

}  // namespace diesink
