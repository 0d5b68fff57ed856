// Facets of a mesh on their way into binary STL. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/mesh.h"

namespace diesink {

// The unit normal of the exact positions: a triangle that float rounding flattens keeps its
// direction. Zero for a degenerate one.
Vec3 facet_normal(const Vec3& a, const Vec3& b, const Vec3& c);

// 50 bytes each: facet_normal() and the corners as floats, rounded to nearest and never -0, and an
// attribute of 0. `to` needs no alignment and has room for all of them.
// Needs: every number below positions.size().
void put_facets(std::span<const Vec3> positions,
                std::span<const std::array<std::uint32_t, 3>> triangles, char* to);

}  // namespace diesink
