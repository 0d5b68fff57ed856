// Tool paths as files: APT CL-data, G-code and CSV, read and written.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/diagnostics.h"
#include "core/tool_path.h"
#include "formats/byte_sink.h"
#include "formats/text_source.h"

namespace diesink {

enum class PathFormat : std::uint8_t { kApt, kGcode, kCsv };

// The dialect of an APT file: the order of words in FEDRAT, SPINDL and the tool statement.
enum class AptFlavour : std::uint8_t { kApt, kNx, kCatia, kCreo };

struct PathWriteOptions {
  std::string program_comment;  // "diesink 0.1.0"; never a date: the same path gives the same bytes
  AptFlavour flavour = AptFlavour::kApt;
};

class PathText;  // one format's (path_formats.h)

// By the ending; nothing where unknown.
std::optional<PathFormat> path_format_of_ending(std::string_view file_name);
// All endings it knows, with blanks between, for messages.
std::string path_endings();
// By the first statement, then by the ending; nothing where neither tells.
std::optional<PathFormat> path_format_of_content(std::string_view text, std::string_view file_name);

// Writes paths piece by piece, as a planner hands them out. Numbers are fixed, with so many
// decimals that rounding stays below a thousandth of the smaller tolerance; the locale does not
// matter.
class PathWriter final : public PathReceiver {
 public:
  // Needs: `sink` outlives it.
  PathWriter(PathFormat format, PathWriteOptions options, ByteSink& sink);
  ~PathWriter() override;
  Status begin(const ToolPath& head) override;
  Status take(std::span<const ClPoint> points) override;
  // What stands behind the points. Errors: kInput for a path without a cutting move; what the sink
  // returns.
  Status finish();

 private:
  PathWriteOptions options_;
  ByteWriter out_;
  std::unique_ptr<PathText> text_;
  std::size_t points_ = 0;
  bool cuts_ = false;
};

// The same for a path that is held whole.
Status write_path(const ToolPath& path, PathFormat format, const PathWriteOptions& options,
                  ByteSink& sink);

// Reads a path of any of the formats. Empty where there was an error; errors (at most 20) and
// warnings with line and column. Never throws for bad data. What a statement changes that this
// program does not model (tilted axes, cycles, variables) is an error, never passed over; words
// without motion are. A path is in its file's unit; the cutter is the file's, where it states one.
std::optional<ToolPath> read_path(std::string_view text, const std::string& file_name,
                                  PathFormat format, Diagnostics& diagnostics);

// The same for a text that comes in blocks: what is not points, while the points go to `take`. The
// file's unit and cutter may stand behind the first of them.
std::optional<ToolPath> read_path(TextSource& text, const std::string& file_name, PathFormat format,
                                  const PathTaker& take, Diagnostics& diagnostics);

// Digits after the point that write_path uses.
int path_decimals(const ToolPath& path);

// How far a controller may round corners off (G64 P): the part of the smaller tolerance that
// planned paths leave to it. 0 where it must not.
double blend_tolerance(const ToolPath& path);

}  // namespace diesink
