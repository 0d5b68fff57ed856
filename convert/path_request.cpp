// Path options of the command line, their defaults, and the figures of a planned path as JSON.
// SPDX-License-Identifier: Apache-2.0
#include "convert/path_request.h"

#include <cmath>
#include <numbers>

#include "formats/json_writer.h"
#include "formats/text_number.h"

namespace diesink {
namespace {

// Feeds of a program that states none, a minute.
constexpr double kUsualFeed = 1000, kUsualFeedInch = 40;

Error usage(std::string message) {
  return {ErrorCode::kUsage, std::move(message), {"diesink", 0, 0, -1}};
}

Status take_along(const PathRequest& request, PathOptions& path) {
  path.along = request.along == "u"   ? PathAlong::kU
               : request.along == "v" ? PathAlong::kV
                                      : PathAlong::kAngle;
  if (path.along != PathAlong::kAngle) {
    if (request.method == PathMethod::kCc) return ok();
    return usage("--along " + request.along + " needs --method cc");
  }
  if (request.along == "x") return ok();
  double degrees = 90;
  if (request.along != "y") {
    const std::optional<double> number = number_of(request.along);
    if (!number || std::fabs(*number) > 360) {
      return usage("--along: '" + request.along + "' is none of x, y, u, v or an angle in degrees");
    }
    degrees = *number;
  }
  path.angle = degrees * std::numbers::pi / 180;
  return ok();
}

}  // namespace

Result<PathOptions> path_options(const PathRequest& request, const PartProgram& program) {
  PathOptions path = path_options_of(program);
  if (request.cutter) path.cutter = {(*request.cutter)[0], (*request.cutter)[1]};
  if (!(path.cutter.diameter > 0)) {
    return Error{ErrorCode::kInput,
                 "no cutter: expected CUTTER,d,r in MACHI-DEF or --cutter D,R",
                 {program.file, 0, 0, -1}};
  }
  path.method = request.method;
  path.pattern = request.pattern;
  path.keep_interference = request.keep_interference;
  if (request.interval) {
    path.interval = request.interval;
    path.cusp.reset();
  }
  if (request.cusp) {
    path.cusp = request.cusp;
    path.interval.reset();
  }
  // A spacing of the command line is the option's fault, not the part program's.
  if (request.interval || request.cusp) {
    if (const Status spaced = check_spacing(path, program.machining); !spaced) {
      return usage((request.interval ? "--interval: " : "--cusp: ") + spaced.error().message);
    }
  }
  path.intol = request.intol.value_or(path.intol);
  path.outtol = request.outtol.value_or(path.outtol);
  if ((request.intol || request.outtol) && path.intol <= 0 && path.outtol <= 0) {
    return usage(std::string(request.intol ? "--intol" : "--outtol") +
                 ": overcut and undercut cannot both be 0");
  }
  if (request.clear) path.clearance = request.clear;
  if (Status taken = take_along(request, path); !taken) return taken.error();
  return path;
}

void set_speeds(ToolPath& path, const PathRequest& request) {
  const double usual = path.unit == LengthUnit::kInch ? kUsualFeedInch : kUsualFeed;
  path.feed = request.feed.value_or(path.feed > 0 ? path.feed : usual);
  path.spindle = request.spindle.value_or(path.spindle);
}

bool is_kept(const PathReport& r, const PathOptions& options) {
  return r.uncertified_area <= 0 && r.left_area <= 0 && r.unsettled_area <= 0 &&
         r.overcut_bound <= options.intol * (1 + 1e-9);
}

double cutting_minutes(const PathReport& r, const PathRequest& request,
                       const PartProgram& program) {
  ToolPath path;
  path.unit = program.unit;
  path.feed = program.machining.feed.value_or(0);
  set_speeds(path, request);
  return r.feed_length / path.feed;
}

std::string to_json(const PathReport& r, double minutes, double seconds) {
  JsonWriter json;
  json.begin_object()
      .field("passes", r.passes)
      .field("points", r.points)
      .field("feed_length", r.feed_length)
      .field("rapid_length", r.rapid_length)
      .field("cutting_minutes", minutes)
      .field("added_runs", r.added_runs)
      .field("wall_runs", r.wall_runs)
      .field("closing_runs", r.closing_runs)
      .field("least_interval", r.least_interval)
      .field("greatest_interval", r.greatest_interval)
      .field("overcut_bound", r.overcut_bound)
      .field("undercut_bound", r.undercut_bound)
      .field("mesh_deviation", r.mesh_deviation)
      .field("unsettled_area", r.unsettled_area)
      .field("left_area", r.left_area)
      .field("left_height", r.left_height)
      .field("left_spacing", r.left_spacing)
      .field("uncertified_area", r.uncertified_area)
      .field("unreachable_area", r.unreachable_area)
      .field("unproven_area", r.unproven_area)
      .field("unreachable_height", r.unreachable_height)
      .field("loops_removed", r.loops_removed)
      .field("crossings_inserted", r.crossings_inserted)
      .field("seconds", seconds)
      .end_object();
  return json.text();
}

}  // namespace diesink
