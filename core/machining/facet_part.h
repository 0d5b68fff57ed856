// A convex part of a facet of the mesh. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/base/base_surface.h"
#include "core/mesh.h"

namespace diesink {

// Its corners lie on the facet's plane, anticlockwise in plan.
struct FacetPart {
  static constexpr std::size_t kMostCorners = 16;
  std::array<Vec3, kMostCorners> p;
  std::size_t size = 0;
  std::uint32_t facet = 0;   // of whoever made it
  std::optional<Vec3> from;  // a tip from which the cutter comes low enough over all of it

  [[nodiscard]] std::span<const Vec3> corners() const { return {p.data(), size}; }
  [[nodiscard]] Vec3 middle() const;
  [[nodiscard]] double area() const;  // in plan
  [[nodiscard]] PlanBox box() const;
};

// The wider side of a box.
inline double wider_side(const PlanBox& box) { return std::fmax(box.x1 - box.x0, box.y1 - box.y0); }

// The part on the side of the line that `side` is not negative on.
template <class Side>
FacetPart cut_by(const FacetPart& in, const Side& side) {
  FacetPart out;
  out.facet = in.facet;
  out.from = in.from;
  for (std::size_t k = 0; k < in.size; ++k) {
    const Vec3 &a = in.p[k], &b = in.p[(k + 1) % in.size];
    const double da = side(a), db = side(b);
    if (da >= 0) out.p[out.size++] = a;
    if ((da > 0 && db < 0) || (da < 0 && db > 0)) out.p[out.size++] = a + da / (da - db) * (b - a);
  }
  return out;
}

// Both halves across the wider side.
std::array<FacetPart, 2> halves(const FacetPart& part);

}  // namespace diesink
