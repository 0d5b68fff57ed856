// Places between passes that no bound settles, looked at on lattices of their own.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <span>
#include <vector>

#include "core/machining/left_over.h"

namespace diesink {

class DoubtfulPlaces {
 public:
  // As LeftOver, of whose lattices each spans some of the places; `spacing` of them.
  DoubtfulPlaces(const CompoundSurface& surface, const OffsetSurface& offset, const PointDrop& drop,
                 const CutterShape& cutter, const FrameDomain& domain, const LeftOverLimits& limits,
                 double spacing, int threads);

  // A move of the cutter's tip.
  void cut(const Vec3& from, const Vec3& to);

  // Where the tip stands in a strip that could not be bounded. All that a cutter there touches is
  // looked at. Needs: no move that matters is forgotten.
  void add(std::span<const PlanBox> tips);

  // What lies before y (behind it, where passes come down from high y) is not added any more.
  void forget(double y, bool down);

  [[nodiscard]] std::deque<LeftOver>& looks() { return looks_; }

 private:
  struct Move {
    Vec3 from, to;
  };
  const CompoundSurface* surface_;
  const OffsetSurface* offset_;
  const PointDrop* drop_;
  CutterShape cutter_;
  FrameDomain domain_;
  LeftOverLimits limits_;
  double spacing_;
  int threads_;
  std::vector<Move> kept_;
  std::deque<LeftOver> looks_;
};

}  // namespace diesink
