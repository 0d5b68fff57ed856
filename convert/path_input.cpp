// Reading tool paths for the subcommands.
// SPDX-License-Identifier: Apache-2.0
#include "convert/path_input.h"

#include "formats/input_file.h"
#include "formats/path_file.h"
#include "formats/registry.h"

namespace diesink {

bool is_path(std::span<const std::byte> bytes, const std::string& name) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (!path_format_of_content(text, name) || format_of_ending(name) != nullptr) return false;
  return path_format_of_ending(name) || format_of_content(bytes, name) == nullptr;
}

Loaded<ToolPath> load_path(const std::string& name) {
  const Result<InputBytes> file = read_file(name);
  if (!file) return {std::nullopt, report(file.error())};
  return load_path(file->bytes(), name);
}

Loaded<ToolPath> load_path(std::span<const std::byte> bytes, const std::string& name) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::string shown = name == "-" ? "stdin" : name;
  const std::optional<PathFormat> format = path_format_of_content(text, name);
  if (!format) {
    return {std::nullopt,
            report(Error{ErrorCode::kInput,
                         "no tool path that is known; expected APT, G-code or CSV (x,y,z,motion)",
                         {shown, 0, 0, -1}})};
  }
  Diagnostics diagnostics;
  std::optional<ToolPath> path = read_path(text, shown, *format, diagnostics);
  return {std::move(path), report(diagnostics)};
}

void to_unit(ToolPath& path, LengthUnit unit) {
  const double scale = metres_per(path.unit) / metres_per(unit);
  path.unit = unit;
  if (scale == 1) return;
  for (ClPoint& point : path.points) point.tip *= scale;
  if (path.cutter)
    path.cutter = Cutter{path.cutter->diameter * scale, path.cutter->corner_radius * scale};
  path.intol *= scale;
  path.outtol *= scale;
}

}  // namespace diesink
