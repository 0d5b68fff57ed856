// The last look at a finished mesh: what went wrong on the way to it is told, whatever it was.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/tessellate/tessellate.h"

namespace diesink {

// Looks at every triangle that claims to be a face: it has area, it looks up, and the surface at
// points of it, found by evaluation alone, is within max(tolerance, certified_deviation) and shows
// the triangle's element within that distance. Points of every body's shadow are looked up in the
// mesh as well, so that a face that was lost is missed, and curves have to lie on their faces
// (curve_check.h). What does not hold goes into report.uncertified_area with its plan area, and
// into report.doubts; the mesh stays as it is.
// Units:  the program's.
// Needs:  `made` complete but for this.
// Bound:  no proof: a face lost between the points is not seen. Points are no farther apart than
//         1/14 of the domain's mean side, and no triangle or body is without one. What looks down
//         by less than rounding may turn an upright triangle does not count.
void last_check(const CompoundSurface& surface, int threads, Tessellation& made);

}  // namespace diesink
