// How deep single points lie in the volume a path sweeps: where a wall is near, straight down is
// not the way out.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/machining/sweep_depth.h"

namespace diesink {

class PointDepths {
 public:
  PointDepths(const CutterShape& cutter, std::vector<Vec3> points);

  // Takes the next moves of a path; the same depths for any division and any thread count.
  void add(std::span<const SweepMove> moves, int threads);

  // Of each point, in the order given: the depth in the move that holds it deepest; 0 outside.
  [[nodiscard]] const std::vector<double>& depths() const { return depths_; }

 private:
  CutterShape cutter_;
  std::vector<Vec3> points_;
  std::vector<std::uint32_t> order_;  // by y, in blocks
  std::vector<double> depths_;
};

}  // namespace diesink
