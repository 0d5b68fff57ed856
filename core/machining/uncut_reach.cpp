// What the proof of a path knows of places that the cutter does not reach.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/machining/uncut_proof.h"

namespace diesink {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace

double UncutProof::lift(const FacetPart& part, double distance) const {
  const Facet& own = facets_[part.facet];
  const Vec2 slope = -own.n.head<2>() / own.n.z();
  const double base = own.v[0].z() - slope.dot(own.v[0].head<2>());
  const PlanBox box = part.box();
  const PlanBox near{box.x0 - distance, box.x1 + distance, box.y0 - distance, box.y1 + distance};
  double lift = distance / own.n.z();
  around_->over(near, [&](std::uint32_t other) {
    if (other == part.facet) return;
    // All that is so near in plan, and all below it, lies under the part's plane, raised by what
    // it rises over that; and it lies under its own plane.
    FacetPart met;
    const Facet& facet = facets_[other];
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec2 from = facet.v[k].head<2>(), side = facet.v[(k + 1) % 3].head<2>() - from;
      const double far = distance * side.norm();
      const bool beside = std::ranges::all_of(part.corners(), [&](const Vec3& p) {
        return side.y() * (p.x() - from.x()) - side.x() * (p.y() - from.y()) > far;
      });
      if (beside) return;
    }
    for (const Vec3& v : facet.v) met.p[met.size++] = v;
    met = cut_by(met, [&](const Vec3& p) { return p.x() - near.x0; });
    met = cut_by(met, [&](const Vec3& p) { return near.x1 - p.x(); });
    met = cut_by(met, [&](const Vec3& p) { return p.y() - near.y0; });
    met = cut_by(met, [&](const Vec3& p) { return near.y1 - p.y(); });
    double raised = -kInfinity, above = kInfinity;
    for (std::size_t k = 0; k < met.size; ++k) {
      raised = std::max(raised, met.p[k].z() - base - slope.dot(met.p[k].head<2>()));
    }
    if (!(raised > 0)) return;
    for (std::size_t k = 0; k < part.size; ++k) {
      above = std::min(above, facet.n.dot(part.p[k] - facet.v[0]));
    }
    lift =
        std::max(lift, std::min(raised + distance / own.n.z(), (distance - above) / facet.n.z()));
  });
  return lift;
}

bool UncutProof::kept_from(const FacetPart& part, const Vec3& tip) const {
  return std::ranges::all_of(part.corners(), [&](const Vec3& p) {
    return keeps(part.facet, part.facet, p, reach_->height(tip, p.head<2>()));
  });
}

}  // namespace diesink
