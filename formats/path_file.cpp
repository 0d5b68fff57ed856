// SPDX-License-Identifier: Apache-2.0
#include "formats/path_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "formats/path_formats.h"
#include "formats/path_text.h"

namespace diesink {
namespace {

constexpr double kLeastRate = 1e-3;  // of feeds and speeds: the last digit that is written

struct PathEnding {
  std::string_view ending;
  PathFormat format;
};

constexpr std::array kEndings{
    PathEnding{".apt", PathFormat::kApt},    PathEnding{".cls", PathFormat::kApt},
    PathEnding{".ncl", PathFormat::kApt},    PathEnding{".aptsource", PathFormat::kApt},
    PathEnding{".cldata", PathFormat::kApt}, PathEnding{".ngc", PathFormat::kGcode},
    PathEnding{".nc", PathFormat::kGcode},   PathEnding{".gcode", PathFormat::kGcode},
    PathEnding{".tap", PathFormat::kGcode},  PathEnding{".csv", PathFormat::kCsv}};

bool ends_in(std::string_view name, std::string_view ending) {
  if (name.size() <= ending.size()) return false;
  const std::string tail = upper_case(name.substr(name.size() - ending.size()));
  return tail == upper_case(ending);
}

// A first line that can only be one format.
std::optional<PathFormat> format_of_line(std::string_view line) {
  const std::string upper = upper_case(line);
  const auto begins = [&](std::string_view word) {
    return upper.compare(0, word.size(), word) == 0;
  };
  if (begins("X,Y,Z")) return PathFormat::kCsv;
  for (const std::string_view word :
       {"PARTNO", "$$",         "UNITS",  "MACHIN", "MULTAX", "TOOL PATH", "PPRINT",
        "CUTTER", "LOADTL",     "INTOL",  "GOTO",   "FROM",   "SPINDL",    "FEDRAT",
        "LOAD/",  "CATPROCESS", "TLDATA", "MSYS",   "RAPID",  "REMARK",    "CATMAT"}) {
    if (begins(word)) return PathFormat::kApt;
  }
  if (upper[0] == '%' || upper[0] == '(' || upper[0] == ';') return PathFormat::kGcode;
  if (upper.size() > 1 && std::string_view("GNOMTSF").find(upper[0]) != std::string_view::npos &&
      ((upper[1] >= '0' && upper[1] <= '9') || upper[1] == ' ')) {
    return PathFormat::kGcode;
  }
  return std::nullopt;
}

// Files hold no larger numbers, nor does any reader take them.
Status check_number(const char* what, double value) {
  if (std::fabs(value) <= kLargestPathNumber) return ok();  // false for what is not a number
  return Error{ErrorCode::kInput,
               std::string(what) + " of the tool path is not a number of at most 1e9 (got " +
                   to_text(value) + ")",
               {}};
}

Status check_head(const ToolPath& head) {
  const Cutter cutter = head.cutter.value_or(Cutter{});
  for (const auto& [what, value] :
       {std::pair{"the feed", head.feed}, std::pair{"the spindle speed", head.spindle}}) {
    if (Status fits = check_number(what, value); !fits) return fits;
    // A feed of 0 stops the machine.
    if (value > 0 && value < kLeastRate) {
      return Error{ErrorCode::kInput,
                   std::string(what) + " of " + to_text(value) + " is too small to be written; " +
                       to_text(kLeastRate) + " a minute or more is expected",
                   {}};
    }
  }
  for (const auto& [what, value] :
       {std::pair{"INTOL", head.intol}, std::pair{"OUTTOL", head.outtol},
        std::pair{"the cutter's diameter", cutter.diameter},
        std::pair{"the cutter's corner radius", cutter.corner_radius}}) {
    if (Status fits = check_number(what, value); !fits) return fits;
  }
  return ok();
}

}  // namespace

std::optional<PathFormat> path_format_of_ending(std::string_view file_name) {
  for (const PathEnding& known : kEndings) {
    if (ends_in(file_name, known.ending)) return known.format;
  }
  return std::nullopt;
}

std::string path_endings() {
  std::string text;
  for (const PathEnding& known : kEndings)
    text += (text.empty() ? "" : " ") + std::string(known.ending);
  return text;
}

std::optional<PathFormat> path_format_of_content(std::string_view text,
                                                 std::string_view file_name) {
  text = text_of(std::as_bytes(std::span(text)));
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    const std::string_view line = without_blanks(text.substr(0, std::min<std::size_t>(end, 200)));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (line.empty() || line == "\r" || line[0] == '#') continue;
    if (const std::optional<PathFormat> format = format_of_line(line)) return format;
    break;
  }
  return path_format_of_ending(file_name);
}

int path_decimals(const ToolPath& path) {
  const double in = path.intol, out = path.outtol;
  const double tolerance = in > 0 && out > 0 ? std::fmin(in, out) : std::fmax(in, out);
  if (!(tolerance > 0)) return 6;
  return std::clamp(static_cast<int>(std::ceil(3 - std::log10(tolerance) - 1e-9)), 3, 9);
}

double blend_tolerance(const ToolPath& path) {
  return kBlendPart * std::fmax(0, std::fmin(path.intol, path.outtol));
}

PathWriter::PathWriter(PathFormat format, PathWriteOptions options, ByteSink& sink)
    : options_(std::move(options)), out_(sink) {
  switch (format) {
    case PathFormat::kApt:
      text_ = apt_text();
      break;
    case PathFormat::kGcode:
      text_ = gcode_text();
      break;
    case PathFormat::kCsv:
      text_ = path_csv_text();
      break;
  }
}

PathWriter::~PathWriter() = default;

Status PathWriter::begin(const ToolPath& head) {
  if (Status fits = check_head(head); !fits) return fits;
  text_->begin(head, options_, out_);
  return out_.status();
}

Status PathWriter::take(std::span<const ClPoint> points) {
  for (const ClPoint& point : points) {
    for (int k = 0; k < 3; ++k) {
      if (Status fits = check_number("a coordinate", point.tip[k]); !fits) return fits;
    }
    cuts_ = cuts_ || point.motion == Motion::kFeed;
    text_->point(point, out_);
  }
  points_ += points.size();
  return out_.status();
}

Status PathWriter::finish() {
  if (!cuts_ || points_ < 2) {
    return Error{ErrorCode::kInput, "the tool path has no cutting move", {}};
  }
  text_->end(out_);
  return out_.finish();
}

Status write_path(const ToolPath& path, PathFormat format, const PathWriteOptions& options,
                  ByteSink& sink) {
  PathWriter writer(format, options, sink);
  if (Status done = writer.begin(path); !done) return done;
  if (Status done = writer.take(path.points); !done) return done;
  return writer.finish();
}

std::optional<ToolPath> read_path(TextSource& text, const std::string& file_name, PathFormat format,
                                  const PathTaker& take, Diagnostics& diagnostics) {
  ToolPath head;
  PointsRead points(take);
  const std::size_t errors = diagnostics.error_count();
  switch (format) {
    case PathFormat::kApt:
      read_apt(text, file_name, head, points, diagnostics);
      break;
    case PathFormat::kGcode:
      read_gcode(text, file_name, head, points, diagnostics);
      break;
    case PathFormat::kCsv:
      read_path_csv(text, file_name, head, points, diagnostics);
      break;
  }
  points.hand_on();
  if (const Status read = text.status(); !read)
    diagnostics.error(read.error().message, read.error().where);
  if (diagnostics.error_count() == errors && points.count() < 2) {
    diagnostics.error("the file holds no tool path: expected at least two positions",
                      {file_name, 0, 0, -1});
  }
  if (diagnostics.error_count() != errors) return std::nullopt;
  return head;
}

std::optional<ToolPath> read_path(std::string_view text, const std::string& file_name,
                                  PathFormat format, Diagnostics& diagnostics) {
  HeldText held(text);
  std::vector<ClPoint> points;
  std::optional<ToolPath> path = read_path(
      held, file_name, format,
      [&](std::span<const ClPoint> some) { points.insert(points.end(), some.begin(), some.end()); },
      diagnostics);
  if (path) path->points = std::move(points);
  return path;
}

}  // namespace diesink
