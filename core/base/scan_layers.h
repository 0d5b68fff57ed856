// What is seen from above of a scan whose triangles lie over one another or end in the air.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/scan_sheet.h"
#include "core/base/scanned.h"

namespace diesink {

// Fills sheet.triangles with what is seen of the faces, and sets unproven_area and moved. Where a
// layer ends over a lower one, and at the top of an upright wall, a strip about `lean` wide in plan
// on the lower layer leads down to it: what stands for the wall (layer_cells.h).
// `faces` are the scan's triangles by their numbers there, over the sheet's points and
// anticlockwise in plan; kNone for those without an area in plan.
// Needs:  lean > 0, small beside the triangles; points of the sheet welded.
// Bound:  everywhere else the sheet is pieces of the scan's own triangles, off by not more than
//         `moved`, which is at most twice `lean`; what lines that came too close to be told apart
//         leave unknown is told in unproven_area.
void join_layers(const ScannedSurface& scan, const std::vector<std::array<std::uint32_t, 3>>& faces,
                 double lean, int threads, ScanSheet& sheet);

}  // namespace diesink
