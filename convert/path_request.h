// What is asked of a tool path on the command line, put together with what the part program states.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>

#include "core/machining/tool_path_plan.h"

namespace diesink {

// Units: the part program's, feed in them a minute; what is empty is as the program states it.
struct PathRequest {
  std::optional<std::array<double, 2>> cutter;  // diameter and corner radius
  std::optional<double> interval, cusp, intol, outtol, feed, spindle, clear;
  std::string along = "x";  // x, y, u, v or an angle in degrees
  PathPattern pattern = PathPattern::kZigzag;
  PathMethod method = PathMethod::kDrop;
  bool keep_interference = false;
};

// Errors: kUsage for a direction that is none, or that the method does not have, and for a spacing
// asked for here that check_spacing() refuses or tolerances that leave no room; kInput without a
// cutter.
Result<PathOptions> path_options(const PathRequest& request, const PartProgram& program);

// Feed and spindle as asked for, else as the program states them, else a usual feed.
void set_speeds(ToolPath& path, const PathRequest& request);

// Of the moves at the feed that set_speeds() gives.
double cutting_minutes(const PathReport& report, const PathRequest& request,
                       const PartProgram& program);

// True where the path is proven to keep the overcut tolerance everywhere, and nothing is known to
// stay higher than asked where the cutter fits.
bool is_kept(const PathReport& report, const PathOptions& options);

// One JSON object.
std::string to_json(const PathReport& report, double minutes, double seconds);

}  // namespace diesink
