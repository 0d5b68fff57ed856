// Material libraries of OBJ files.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "core/diagnostics.h"
#include "formats/element_table.h"

namespace diesink {

// Adds the diffuse colours (Kd, d or Tr) of the library `name` in `folder` to `colors`. A name that
// leads out of the folder, or to anything but a file of at most 16 MiB, is not opened. What cannot
// be read is told in a warning at `where`: without colours the mesh is still a mesh.
void read_materials(const std::string& folder, std::string_view name, const Place& where,
                    std::map<std::string, Color, std::less<>>& colors, Diagnostics& diagnostics);

// Whether `name`, a path in a file, stays inside the folder it is relative to: not absolute, no
// "..", no backslash, no scheme.
bool stays_inside(std::string_view name);

}  // namespace diesink
