// The profile of the tip's height along any straight plan segment: what proves a single move.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/machining/drop.h"
#include "core/machining/pass_profile.h"

namespace diesink {

class SegmentProfile {
 public:
  // `chord` as in slice_piece. Needs: both outlive it; `drop` is of `offset`. One a thread.
  SegmentProfile(const OffsetSurface& offset, const PointDrop& drop, double chord)
      : offset_(&offset), drop_(&drop), chord_(chord) {}

  // The upper envelope over the segment from a to b, x counted from a, of all that can lift the tip
  // above `floor`. Valid until the next call.
  // Bound: at most `chord` below the tip's true height where that is above `floor`, never above it.
  const std::vector<ProfileSegment>& take(const Vec2& a, const Vec2& b, double floor);

  // The most by which the straight move of the tip from a to b lies under the lowest safe height:
  // an upper bound, over every point of the move; at most 0 for a safe move. `at` is the place of
  // the profile's corner that decides it, at its safe height. Depths below `floor` may come out as
  // `floor`.
  double deepest(const Vec3& a, const Vec3& b, double floor, Vec3& at);

 private:
  const OffsetSurface* offset_;
  const PointDrop* drop_;
  double chord_;
  std::vector<std::uint32_t> pieces_;
  std::vector<ProfileSegment> profile_;
  UpperEnvelope envelope_;
};

}  // namespace diesink
