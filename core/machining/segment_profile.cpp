// SPDX-License-Identifier: Apache-2.0
#include "core/machining/segment_profile.h"

#include <algorithm>
#include <cmath>

namespace diesink {

const std::vector<ProfileSegment>& SegmentProfile::take(const Vec2& a, const Vec2& b,
                                                        double floor) {
  profile_.clear();
  pieces_.clear();
  const PlanLine line(a, b);
  if (!(line.length > 0)) return profile_;
  drop_->pieces_along(a, b, floor, pieces_);
  std::sort(pieces_.begin(), pieces_.end());
  pieces_.erase(std::unique(pieces_.begin(), pieces_.end()), pieces_.end());
  for (const std::uint32_t k : pieces_) slice_piece_along(*offset_, k, line, chord_, profile_);
  envelope_.take(profile_);
  return profile_;
}

double SegmentProfile::deepest(const Vec3& a, const Vec3& b, double floor, Vec3& at) {
  // The ends exactly; they also serve a move straight up or down.
  double worst = floor;
  const auto weigh = [&](const Vec2& p, double lowest, double z, double slack) {
    if (!(lowest + slack - z > worst)) return;
    worst = lowest + slack - z;
    at = Vec3(p.x(), p.y(), lowest + slack);
  };
  const double za = drop_->at(a.x(), a.y()), zb = drop_->at(b.x(), b.y());
  const PlanLine line(a.head<2>(), b.head<2>());
  if (!(line.length > 0)) {
    weigh(a.head<2>(), za, std::min(a.z(), b.z()), 0);
    return worst;
  }
  weigh(a.head<2>(), za, a.z(), 0);
  weigh(b.head<2>(), zb, b.z(), 0);
  const double slope = (b.z() - a.z()) / line.length;
  for (const ProfileSegment& s : take(a.head<2>(), b.head<2>(), std::min(a.z(), b.z()) + floor)) {
    // Chords only where the piece is round.
    const double slack = s.piece < offset_->facets().size() ? 0 : chord_;
    weigh(line.at(s.x0), s.z0, a.z() + slope * s.x0, slack);
    weigh(line.at(s.x1), s.z1, a.z() + slope * s.x1, slack);
  }
  return worst;
}

}  // namespace diesink
