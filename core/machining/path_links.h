// Runs of passes joined into one path: links over the material, retracts, first and last moves.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "core/machining/offset_surface.h"
#include "core/machining/segment_profile.h"
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

// Hands points on to a receiver, turned out of a frame, and measures them on the way. Nothing is
// handed on before there are enough points for a path.
class PathStream {
 public:
  // Needs: all outlive it.
  PathStream(const OffsetSurface& frame, const ToolPath& head, PathReceiver& receiver,
             PathReport& report)
      : frame_(&frame), head_(&head), receiver_(&receiver), report_(&report) {}

  void add(const Vec3& tip, Motion motion);
  // Calls `watch` with the ends of every cutting move, in the frame.
  void watch(std::function<void(const Vec3& from, const Vec3& to)> watch) {
    watch_ = std::move(watch);
  }
  // The last point in the frame. Needs: empty() is false.
  [[nodiscard]] const Vec3& last() const { return last_; }
  [[nodiscard]] bool empty() const { return report_->points == 0; }
  [[nodiscard]] bool failed() const { return !status_; }
  // Hands on the rest. Errors: kInput for an empty or nearly empty path; the receiver's.
  Status finish();

 private:
  void hand_on();
  const OffsetSurface* frame_;
  const ToolPath* head_;
  PathReceiver* receiver_;
  PathReport* report_;
  Vec3 last_ = Vec3::Zero();
  std::function<void(const Vec3&, const Vec3&)> watch_;
  std::vector<ClPoint> waiting_;
  bool begun_ = false;
  Status status_ = ok();
};

// Joins runs in the order they are cut, each a polyline of tips in one frame.
class PathJoiner {
 public:
  // `lift` is added to the grid's heights (a larger cutter was dropped than is used, say). Links
  // longer than `link_limit` in plan go by the clearance plane. Needs: `tops` and `out` outlive it.
  PathJoiner(const TopGrid& tops, double lift, double clearance, double link_limit, PathStream& out)
      : tops_(&tops), out_(&out), lift_(lift), clearance_(clearance), link_limit_(link_limit) {}

  // From now on links may lead along the surface, where that is quicker than over it: they dip at
  // most `tolerance` under the lowest safe height of the offset's cutter. Needs: `profile` outlives
  // it.
  void follow(SegmentProfile& profile, double tolerance) {
    profile_ = &profile;
    tolerance_ = tolerance;
  }

  // Cuts a run. With `by_clearance` the way to it leads over the clearance plane in any case.
  void cut(std::span<const Vec3> run, bool by_clearance);
  // Retracts.
  void finish();

 private:
  // Length of the link along the surface to a run, its points in link_; infinity where there is
  // none.
  double along_surface(const Vec3& from, const Vec3& to);

  const TopGrid* tops_;
  PathStream* out_;
  double lift_, clearance_, link_limit_, tolerance_ = 0;
  SegmentProfile* profile_ = nullptr;
  std::vector<Vec3> link_;
};

// The height of the rapid moves over a mesh: the one asked for, else a diameter above its top, or
// above what a cutter larger all round by `grow` meets there.
// Errors: kInput where the one asked for is not above that.
Result<double> clearance_over(const TriangleMesh& mesh, const PathOptions& options, double grow);

}  // namespace diesink
