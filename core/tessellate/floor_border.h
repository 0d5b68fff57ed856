// What bounds the floor of a solid in plan: the domain's border, and holes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/tessellate/arc_samples.h"
#include "core/tessellate/planar_triangulation.h"

namespace diesink {

struct FloorBorder {
  std::vector<Vec2> points;
  std::vector<std::uint32_t> arc_point;                // of each
  std::vector<PlanarTriangulation::Segment> segments;  // the surface on the left
};

FloorBorder floor_border(const Arrangement& arrangement, const ArcSamples& samples);

// Chords that cross in plan, where the floor could not be triangulated between them (those of
// regions are told from each other in the charts of their faces); by their arc points.
std::vector<std::array<std::uint32_t, 2>> crossings_of_floor(const FloorBorder& border);

}  // namespace diesink
