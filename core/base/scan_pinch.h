// Borders of layers that meet in a point. SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/scan_sheet.h"

namespace diesink {

// Where facets at different heights meet in one point of the plan and nowhere else, as where single
// facets have been lost, all but the highest end short of it: the corner of each is moved in by not
// more than `lean`. One point then has one height.
// Sets moved. Needs: triangles that look up; twins are not used.
void part_pinches(ScanSheet& sheet, double lean);

}  // namespace diesink
