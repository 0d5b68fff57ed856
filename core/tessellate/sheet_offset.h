// How far a triangle that stands for part of a scan is off it. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "core/base/scanned.h"

namespace diesink {

struct SheetOffset {
  double height = 0;  // off the scan along vertical lines, at most
  double beyond = 0;  // plan area of what no triangle of the scan is under or over
};

// Needs:  a scan no two triangles of which lie over one another; corners anticlockwise in plan.
// Bound:  exact but for rounding: both are flat piece by piece, so that they are farthest apart at
//         a corner of what a triangle of the scan has in common with this one.
SheetOffset sheet_offset(const ScannedSurface& scan, const std::array<Vec3, 3>& corners);

}  // namespace diesink
