// Tool paths of the command line.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

#include "convert/input.h"
#include "core/tool_path.h"

namespace diesink {

// True where the content can be a tool path and is not a mesh; where it could be both, as a first
// line "g 1" is, the ending decides, then the mesh.
bool is_path(std::span<const std::byte> bytes, const std::string& name);

// Reads an APT, G-code or CSV path ("-" is stdin), told by its content; its warnings are told.
Loaded<ToolPath> load_path(const std::string& name);
// The same for the content of `name`, read before.
Loaded<ToolPath> load_path(std::span<const std::byte> bytes, const std::string& name);

// Every length into `unit`.
void to_unit(ToolPath& path, LengthUnit unit);

}  // namespace diesink
