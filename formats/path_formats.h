// The path formats one by one, for path_file.cpp.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "formats/path_file.h"

namespace diesink {

void write_apt(const ToolPath& path, const PathWriteOptions& options, ByteWriter& out);
void write_gcode(const ToolPath& path, const PathWriteOptions& options, ByteWriter& out);
void write_path_csv(const ToolPath& path, ByteWriter& out);

void read_apt(std::string_view text, const std::string& file_name, ToolPath& path,
              Diagnostics& diagnostics);
void read_gcode(std::string_view text, const std::string& file_name, ToolPath& path,
                Diagnostics& diagnostics);
void read_path_csv(std::string_view text, const std::string& file_name, ToolPath& path,
                   Diagnostics& diagnostics);

}  // namespace diesink
