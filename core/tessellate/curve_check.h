// The curves of a finished mesh held against the faces that they are said to part.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/tessellate/tessellate.h"

namespace diesink {

// Every vertex of a crease lies on both its faces, one beside a wall on one of them, one at an end
// of the surface on the face there: on the whole plane or quadric of the face, and on the base.
// What does not is told in report.uncertified_area, with the chords beside it as long as they are
// and as wide as the vertex is off, and in report.doubts. The mesh stays as it is.
// Units:  the program's.
// Needs:  `made` complete, `surface` the one it was made of.
// Bound:  a vertex may be off by 1e-9 of the size; over a scan, whose chords may have been laid
//         straight at a grain, by kUnseen of the tolerance more (arrangement.h); from the scan
//         itself, which may stand upright there, by what is certified.
void check_curves(const CompoundSurface& surface, Tessellation& made);

}  // namespace diesink
