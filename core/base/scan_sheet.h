// The layer of a scan that is seen from above, as one triangulation of the plan.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/base_surface.h"
#include "core/base/scanned.h"
#include "core/vec.h"

namespace diesink {

// Triangles anticlockwise in plan, each with an area there, no two over one another; what they
// leave open is hole. A half-edge is 3 * triangle + corner, from that corner to the next.
struct ScanSheet {
  static constexpr std::uint32_t kNone = 0xFFFFFFFFu;

  std::vector<Vec3> points;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint32_t>
      twin;  // of each half-edge: the other way along it, kNone at the border

  // Plan area over which the sheet is not the scan's top layer to the last digit.
  double unproven_area = 0;
  // At most: by that what stands for upright walls leans in plan, and pieces beside them are off
  // their faces.
  double moved = 0;

  void make_twins();
  [[nodiscard]] std::uint32_t from(std::uint32_t h) const { return triangles[h / 3][h % 3]; }
  [[nodiscard]] std::uint32_t to(std::uint32_t h) const { return from(next(h)); }
  static std::uint32_t next(std::uint32_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
  static std::uint32_t previous(std::uint32_t h) { return h % 3 == 0 ? h + 2 : h - 1; }
  // The triangles round each vertex: begins[v] .. begins[v + 1] in around. (By half-edges that
  // leave it.)
  void fans(std::vector<std::uint32_t>& begins, std::vector<std::uint32_t>& around) const;
};

// The part of the scan over the box, cut off along its sides: the cuts are vertices whose
// coordinate is the side's own to the bit. Where layers lie over one another, or walls stand
// upright, see scan_layers.h: what stands for a wall is a strip `lean` wide in plan.
ScanSheet top_sheet(const ScannedSurface& scan, const PlanBox& box, double lean, int threads = 0);

// How a scan covers a box of the plan.
struct ScanCover {
  double open_area = 0;        // without a surface
  std::size_t open_loops = 0;  // borders of holes within the scan
  double layered_area = 0;     // under the topmost layer, each layer counted
};
ScanCover scan_cover(const ScannedSurface& scan, const PlanBox& box, int threads = 0);

}  // namespace diesink
