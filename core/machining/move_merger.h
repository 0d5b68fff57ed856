// Fewer and longer moves for a path of many tiny ones.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/machining/sweep_depth.h"

namespace diesink {

// Joins moves that follow each other into one straight move as long as every point left out lies
// within `tolerance` of it. Then each position of the cutter on the one lies within it of a
// position on the other, so depths and what stays, along the normal, differ by no more.
class MoveMerger {
 public:
  explicit MoveMerger(double tolerance) : tolerance2_(tolerance * tolerance) {}

  // The path goes on to `tip`; moves that are complete are appended.
  void add(const Vec3& tip, std::vector<SweepMove>& moves);
  void finish(std::vector<SweepMove>& moves);

 private:
  static constexpr std::size_t kMostPoints = 64;
  double tolerance2_;
  bool begun_ = false;
  Vec3 from_ = Vec3::Zero();
  std::vector<Vec3> points_;  // after from_; the last is where the path is
};

}  // namespace diesink
