// Runs of passes joined into one path: links over the material, retracts, first and last moves.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/machining/offset_surface.h"
#include "core/machining/tool_path_plan.h"

namespace diesink {

// Upper bounds of the tip's height over straight plan moves, from the highest pieces of a plan
// grid.
class TopGrid {
 public:
  TopGrid(const OffsetSurface& offset, double cell);

  // No contact over the plan move from a to b is higher; kNoContact where there is none.
  [[nodiscard]] double over(const Vec2& a, const Vec2& b) const;

 private:
  PlanBox extent_;
  int nx_ = 1, ny_ = 1;
  double inv_dx_ = 0, inv_dy_ = 0;
  std::vector<double> tops_;
};

// Gathers runs in the order they are cut, each a polyline of tips in one frame.
class PathJoiner {
 public:
  // `lift` is added to the grid's heights (a larger cutter was dropped than is used, say). Links
  // longer than `link_limit` in plan go by the clearance plane. Needs: `tops` outlives it.
  PathJoiner(const TopGrid& tops, double lift, double clearance, double link_limit)
      : tops_(&tops), lift_(lift), clearance_(clearance), link_limit_(link_limit) {}

  // Cuts a run. With `by_clearance` the way to it leads over the clearance plane in any case.
  void cut(const std::vector<Vec3>& run, bool by_clearance);
  // Retracts; then the points are whole.
  std::vector<ClPoint> finish();

 private:
  void add(const Vec3& tip, Motion motion);
  const TopGrid* tops_;
  double lift_, clearance_, link_limit_;
  std::vector<ClPoint> points_;
};

// Lengths of the moves of each kind, and the points' number, into the report.
void measure(const ToolPath& path, PathReport& report);

}  // namespace diesink
