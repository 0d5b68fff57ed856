// Polygons as triangles: faces of mesh files, and holes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/vec.h"

namespace diesink {

// Above this number of corners a polygon must be convex.
inline constexpr std::size_t kMaxConcaveCorners = 1024;

// Cuts a polygon in space into corners.size() - 2 triangles that turn the way it does: a fan where
// it is convex, else by cutting ears in its mean plane (Newell's normal). Every triangle's numbers
// are indices into `corners`. Needs: at least 3 corners. Errors: false where it crosses itself or
// is flat to a line (it is cut all the same, perhaps with overlaps), and
//         where it is concave with more than kMaxConcaveCorners corners (a fan).
bool cut_polygon(std::span<const Vec3> corners,
                 std::vector<std::array<std::uint32_t, 3>>& triangles);

}  // namespace diesink
