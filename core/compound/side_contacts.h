// Sides that touch along a curve and never cross: the ball at the end of a rib, the fillet in the
// corner of two others. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/compound/body_line.h"

namespace diesink {

// Which quadric sides lie inside which others. Two quadrics F and G touch along a plane curve where
// F - k G is the square of a plane, k > 0: on G then F has one sign. (Concentric ones of one form
// are the same with the plane at infinity.)
// Source: Dupin's and Darboux's theorems on quadrics in double contact; a pencil with a member of
//         rank one.
// Bound:  to `slack`, the length two descriptions of one curve may differ by; what is told apart by
//         less counts as touching.
// Immutable once built; any number of threads.
class SideContacts {
 public:
  // Needs: slack > 0, mm.
  void build(const std::vector<BodyLine>& bodies, double slack);

  // No point of the side of `inner`, its quadric taken whole, is outside the quadric of `outer`.
  [[nodiscard]] bool is_inside(std::int32_t inner, std::int32_t outer) const {
    return touches_[static_cast<std::size_t>(inner)] != 0 && find(inner, outer);
  }

  // The upper or the lower half of a body's side; neither where it is not known which.
  struct Sheet {
    std::int32_t solid = -1;
    bool is_upper = false, is_lower = false;
  };
  // No point of `one` is below `other`: an upper sheet is above all that lies inside its quadric, a
  // lower one below it.
  [[nodiscard]] bool is_above(const Sheet& one, const Sheet& other) const {
    return (one.is_upper && is_inside(other.solid, one.solid)) ||
           (other.is_lower && is_inside(one.solid, other.solid));
  }

 private:
  [[nodiscard]] bool find(std::int32_t inner, std::int32_t outer) const;

  std::vector<char> touches_;          // of each body: whether it is in any pair
  std::vector<std::uint64_t> nested_;  // inner, outer; ascending
};

// How far about a point the line counts in which a plane touches a side: the plan distance from the
// point to the line, and the length of line on both sides of the foot.
struct ContactReach {
  double across = 0, along = 0;
};

// The side on which a plane that is nowhere inside the quadric of a side, but touches it along a
// line or in a point, passes that side: +1 above, -1 below; 0 where it is not such a plane, or not
// told.
// Needs: a side of two heights (SideRule::kBetween with q2 > 0), the plane by a point and its
//        slopes; reach.across > 0.
// Bound: a plane inside by no more than `slack` of height counts as touching.
int side_of_tangent_plane(const BodyLine& body, const Vec3& at, double zx, double zy,
                          const ContactReach& reach, double slack);

}  // namespace diesink
