// The path formats one by one, for path_file.cpp.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "formats/path_file.h"
#include "formats/path_text.h"

namespace diesink {

// One format's part of a PathWriter: what stands before the points, the points as they come, what
// stands behind them.
class PathText {
 public:
  virtual ~PathText() = default;
  virtual void begin(const ToolPath& head, const PathWriteOptions& options, ByteWriter& out) = 0;
  virtual void point(const ClPoint& point, ByteWriter& out) = 0;
  virtual void end(ByteWriter& out) = 0;
};

std::unique_ptr<PathText> apt_text();
std::unique_ptr<PathText> gcode_text();
std::unique_ptr<PathText> path_csv_text();

// Each reads a whole text: what is not points goes into `head`.
void read_apt(TextSource& text, const std::string& file_name, ToolPath& head, PointsRead& points,
              Diagnostics& diagnostics);
void read_gcode(TextSource& text, const std::string& file_name, ToolPath& head, PointsRead& points,
                Diagnostics& diagnostics);
void read_path_csv(TextSource& text, const std::string& file_name, ToolPath& head,
                   PointsRead& points, Diagnostics& diagnostics);

}  // namespace diesink
