// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/floor_border.h"

#include <algorithm>
#include <unordered_map>

namespace diesink {

FloorBorder floor_border(const Arrangement& arrangement, const ArcSamples& samples) {
  FloorBorder border;
  std::unordered_map<std::uint32_t, std::uint32_t> local;
  std::vector<std::uint32_t> chain;
  for (std::uint32_t a = 0; a < arrangement.arcs.size(); ++a) {
    const PlanArc& arc = arrangement.arcs[a];
    if (!(arc.border || arc.left == kNoLabel || arc.right == kNoLabel) ||
        (arc.left == kNoLabel && (arc.border || arc.right == kNoLabel)))
      continue;
    samples.chain(a, chain);
    if (arc.left == kNoLabel) std::reverse(chain.begin(), chain.end());
    const auto number = [&](std::uint32_t p) {
      const auto [it, fresh] =
          local.try_emplace(p, static_cast<std::uint32_t>(border.points.size()));
      if (fresh) {
        border.points.emplace_back(samples.points[p].x, samples.points[p].y);
        border.arc_point.push_back(p);
      }
      return it->second;
    };
    for (std::size_t k = 0; k + 1 < chain.size(); ++k) {
      if (chain[k] != chain[k + 1])
        border.segments.push_back({number(chain[k]), number(chain[k + 1])});
    }
  }
  return border;
}

std::vector<std::array<std::uint32_t, 2>> crossings_of_floor(const FloorBorder& border) {
  PlanarTriangulation triangulation;
  std::vector<std::array<std::uint32_t, 2>> chords;
  const auto ask = [&](std::uint32_t segment) {
    if (segment >= border.segments.size()) return;
    const PlanarTriangulation::Segment& s = border.segments[segment];
    chords.push_back({border.arc_point[s[0]], border.arc_point[s[1]]});
  };
  for (const SegmentCrossing& wrong : triangulation.build(border.points, border.segments)) {
    ask(wrong.segment_a);
    ask(wrong.segment_b);
    if (wrong.segment_b != kNoSegment || wrong.point != kNoPoint) continue;
    // Turned inside out between few long chords, which names one of them alone.
    for (std::uint32_t s = 0; s < border.segments.size(); ++s) ask(s);
    break;
  }
  std::sort(chords.begin(), chords.end());
  chords.erase(std::unique(chords.begin(), chords.end()), chords.end());
  return chords;
}

}  // namespace diesink
