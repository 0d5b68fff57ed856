// Where the passes of the drop method lie.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/machining/frame_domain.h"
#include "core/machining/offset_surface.h"
#include "core/mesh.h"

namespace diesink {

// Positions at a fixed interval: the first and last on the domain's border, equal steps.
std::vector<double> even_passes(const FrameDomain& domain, double interval);

// Positions from the cusp height: contacts along rows about an interval apart set limits (equations
// (15) to (17)), and a step is the longest that keeps those of the rows it passes. Where a small
// part of a row asks for much closer passes than the rest, it is left to runs put in between
// (strip_refine.h). `cutter` is the one that cuts, the offset's may be larger or smaller.
std::vector<double> cusp_passes(const OffsetSurface& offset, const TriangleMesh& mesh,
                                const FrameDomain& domain, const CutterShape& cutter, double cusp,
                                double chord, int threads);

}  // namespace diesink
