// File names of the command line.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "core/result.h"

namespace diesink {

// True for "a/die.STL" and ".stl": upper and lower case are the same; a name that is only the
// ending has none.
bool has_ending(std::string_view path, std::string_view ending);

// That the folder of an output is there: told before the work begins rather than after it. "-"
// passes. Errors: kOutput.
Status check_folder(const std::string& path);

// `path` with `insert` before its ending: tiles of out/die.stl are out/die_0_1.stl.
std::string before_ending(const std::string& path, const std::string& insert);

// The size of a file for people: "128 kB"; "?" where it cannot be told.
std::string size_text(const std::string& path);

}  // namespace diesink
