// SPDX-License-Identifier: Apache-2.0
#include "core/machining/doubtful_places.h"

#include <algorithm>

namespace diesink {
namespace {

bool overlap(const PlanBox& p, const PlanBox& q) {
  return p.x0 <= q.x1 && q.x0 <= p.x1 && p.y0 <= q.y1 && q.y0 <= p.y1;
}

struct Cluster {
  PlanBox box;
  std::vector<PlanBox> places;
};

void take_in(Cluster& into, Cluster from) {
  into.box = {std::min(into.box.x0, from.box.x0), std::max(into.box.x1, from.box.x1),
              std::min(into.box.y0, from.box.y0), std::max(into.box.y1, from.box.y1)};
  std::move(from.places.begin(), from.places.end(), std::back_inserter(into.places));
}

// Boxes of clusters do not overlap, so that no point is looked at twice.
std::vector<Cluster> clusters_of(std::span<const PlanBox> places) {
  std::vector<Cluster> out;
  for (const PlanBox& place : places) {
    Cluster grown{place, {place}};
    for (std::size_t k = 0; k < out.size();) {
      if (!overlap(out[k].box, grown.box)) {
        ++k;
        continue;
      }
      take_in(grown, std::move(out[k]));
      out[k] = std::move(out.back());
      out.pop_back();
      k = 0;  // those passed over may meet it now
    }
    out.push_back(std::move(grown));
  }
  return out;
}

}  // namespace

DoubtfulPlaces::DoubtfulPlaces(const CompoundSurface& surface, const OffsetSurface& offset,
                               const PointDrop& drop, const CutterShape& cutter,
                               const FrameDomain& domain, const LeftOverLimits& limits,
                               double spacing, int threads)
    : surface_(&surface),
      offset_(&offset),
      drop_(&drop),
      cutter_(cutter),
      domain_(domain),
      limits_(limits),
      spacing_(spacing),
      threads_(threads) {}

void DoubtfulPlaces::cut(const Vec3& from, const Vec3& to) {
  kept_.push_back({from, to});
  for (LeftOver& look : looks_) look.cut(from, to);
}

void DoubtfulPlaces::add(std::span<const PlanBox> tips) {
  const double R = cutter_.radius();
  std::vector<PlanBox> places;
  for (const PlanBox& tip : tips) {
    places.push_back({tip.x0 - R, tip.x1 + R, tip.y0 - R, tip.y1 + R});
  }
  for (const Cluster& cluster : clusters_of(places)) {
    LeftOver& look = looks_.emplace_back(*surface_, *offset_, *drop_, cutter_, domain_, limits_,
                                         spacing_, threads_, cluster.places);
    for (const Move& move : kept_) look.cut(move.from, move.to);
  }
}

void DoubtfulPlaces::forget(double y, bool down) {
  // A place reaches a radius beyond its strip, and so does a move beyond its own.
  const double far = 2.1 * cutter_.radius();
  std::erase_if(kept_, [&](const Move& move) {
    return down ? std::min(move.from.y(), move.to.y()) > y + far
                : std::max(move.from.y(), move.to.y()) < y - far;
  });
}

}  // namespace diesink
