// A sheet of a scan with no more vertices than a tolerance needs.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "core/base/scan_sheet.h"

namespace diesink {

struct ThinOptions {
  double tolerance = 0;      // along vertical lines
  double feature_angle = 0;  // radians: edges that turn by more are kept as lines
  PlanBox box;               // on its sides vertices may go; elsewhere the border stays as it is
  std::array<bool, 4> fixed_side{false, false, false, false};  // x0, x1, y0, y1: not even there
  // Of each triangle: whether it stays at all. Empty: all. The sheet is held against the whole of
  // what it was.
  std::vector<char> part;
  // Of each vertex: whether it stays whatever it is worth. Empty: none.
  std::vector<char> fixed;
  // Whether the border may run straight from a to b where it ran over v, between them; at most
  // `share` of what a border may be off counts. Empty: only along the sides of the box.
  std::function<bool(std::uint32_t a, std::uint32_t v, std::uint32_t b, double share)>
      may_straighten;
  std::function<void(std::uint32_t v)> straightened;  // and now it does
};

// Takes vertices away while the sheet that is left stays within the tolerance; those left do not
// move. Edges that turn by more than the feature angle, and the borders of holes, stay lines.
// Returns the largest vertical distance between the sheet as it was and as it is.
// Bound:  both are flat piece by piece: their distance is largest at a vertex of the old sheet or
//         where a new edge passes over an old one, and all of those are looked at.
// Source: vertex removal as in Schroeder, Zarge and Lorensen 1992; targets by the quadrics of
//         Garland and Heckbert 1997.
// kept, where it is asked for: the old number of each vertex.
double thin_sheet(ScanSheet& sheet, const ThinOptions& options,
                  std::vector<std::uint32_t>* kept = nullptr);

}  // namespace diesink
