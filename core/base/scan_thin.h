// A sheet of a scan with no more vertices than a tolerance needs.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/scan_sheet.h"

namespace diesink {

struct ThinOptions {
  double tolerance = 0;      // along vertical lines
  double feature_angle = 0;  // radians: edges that turn by more are kept as lines
  PlanBox box;               // on its sides vertices may go; elsewhere the border stays as it is
  std::array<bool, 4> fixed_side{false, false, false, false};  // x0, x1, y0, y1: not even there
};

// Takes vertices away while the sheet that is left stays within the tolerance; those left do not
// move. Edges that turn by more than the feature angle, and the borders of holes, stay lines.
// Returns the largest vertical distance between the sheet as it was and as it is.
// Bound:  both are flat piece by piece: their distance is largest at a vertex of the old sheet or
//         where a new edge passes over an old one, and all of those are looked at.
// Source: vertex removal as in Schroeder, Zarge and Lorensen 1992; targets by the quadrics of
//         Garland and Heckbert 1997.
double thin_sheet(ScanSheet& sheet, const ThinOptions& options);

}  // namespace diesink
