// What is seen from above of a scan whose triangles lie over one another or end in the air.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/scan_sheet.h"
#include "core/base/scanned.h"

namespace diesink {

// Fills sheet.triangles with what is seen of the faces, and sets unproven_area and moved. A rim,
// the edge of a layer over a lower one or the top of an upright wall, gets a strip `lean` wide in
// plan beside it, outside of the upper layer, that leads down to the lower: what stands for the
// wall. `faces` are the scan's triangles by their numbers there, over the sheet's points and
// anticlockwise in plan; kNone for those without an area in plan. Needs:  lean > 0, small beside
// the triangles; points of the sheet welded. Bound:  everywhere else the sheet is pieces of the
// scan's own triangles; where lines came too
//         close to be told apart the pieces are held against the scan at points, and what is off by
//         more than `lean` is told in unproven_area.
void join_layers(const ScannedSurface& scan, const std::vector<std::array<std::uint32_t, 3>>& faces,
                 double lean, int threads, ScanSheet& sheet);

}  // namespace diesink
