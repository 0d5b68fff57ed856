// Reading tool paths for the subcommands.
// SPDX-License-Identifier: Apache-2.0
#include "convert/path_input.h"

#include "formats/registry.h"

namespace diesink {

bool is_path(std::span<const std::byte> bytes, const std::string& name) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (!path_format_of_content(text, name) || format_of_ending(name) != nullptr) return false;
  return path_format_of_ending(name) || format_of_content(bytes, name) == nullptr;
}

namespace {

Error not_a_path(const std::string& shown) {
  return {ErrorCode::kInput,
          "no tool path that is known; expected APT, G-code or CSV (x,y,z,motion)",
          {shown, 0, 0, -1}};
}

}  // namespace

Loaded<PathInput> PathInput::open(const std::string& name) {
  PathInput input;
  input.shown_ = name == "-" ? "stdin" : name;
  Result<std::unique_ptr<TextSource>> file = open_text(name);
  if (name != "-" && file) {
    input.text_ = std::move(*file);
  } else {
    // A pipe, or a message of read_file's.
    Result<InputBytes> bytes = read_file(name);
    if (!bytes) return {std::nullopt, report(bytes.error())};
    input.bytes_ = std::move(*bytes);
    const std::span<const std::byte> all = input.bytes_.bytes();
    input.text_ = std::make_unique<HeldText>(
        std::string_view(reinterpret_cast<const char*>(all.data()), all.size()));
  }
  const std::optional<PathFormat> format = path_format_of_content(input.text_->next(), name);
  if (const Status read = input.text_->status(); !read) return {std::nullopt, report(read.error())};
  if (!format) return {std::nullopt, report(not_a_path(input.shown_))};
  input.format_ = *format;
  input.text_->rewind();
  Diagnostics diagnostics;
  std::optional<ToolPath> head = read_path(
      *input.text_, input.shown_, *format, [](std::span<const ClPoint>) {}, diagnostics);
  const ExitStatus told = report(diagnostics);
  if (!head) return {std::nullopt, told};
  input.head_ = std::move(*head);
  return {std::move(input), told};
}

Status PathInput::points(LengthUnit unit, const PathTaker& take) {
  const double scale = metres_per(head_.unit) / metres_per(unit);
  Diagnostics again;  // told before
  std::vector<ClPoint> scaled;
  text_->rewind();
  const auto head = read_path(
      *text_, shown_, format_,
      [&](std::span<const ClPoint> points) {
        if (scale == 1) return take(points);
        scaled.assign(points.begin(), points.end());
        for (ClPoint& point : scaled) point.tip *= scale;
        take(scaled);
      },
      again);
  if (head) return ok();
  return Error{ErrorCode::kInput, "the file has changed while it was read", {shown_, 0, 0, -1}};
}

Loaded<ToolPath> load_path(std::span<const std::byte> bytes, const std::string& name) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::string shown = name == "-" ? "stdin" : name;
  const std::optional<PathFormat> format = path_format_of_content(text, name);
  if (!format) {
    return {std::nullopt, report(not_a_path(shown))};
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
  path.arc_height *= scale;
}

}  // namespace diesink
