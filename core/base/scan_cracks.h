// Facets of a scan that meet but for rounding. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "core/base/scanned.h"
#include "core/mesh.h"

namespace diesink {

// The triangles of a scan with cracks closed: vertices of edges that one facet alone has become one
// where they lie within `width` of one another, and what then has two corners in one is left out;
// those within `width` of a side of the domain go onto it. Rounding and stitching leave such gaps
// and overlaps between facets, turning a scan such slivers beside its border; each would be a hole
// of its own, or a layer. Where most facets share no edge with another, it is `loose_width` then:
// they have been written one by one.
// Needs:  widths > 0.
// Bound:  no vertex moves by more than 2.5 widths, or 2.5 of both.
// Errors: nothing where no vertex moves.
struct ClosedScan {
  TriangleMesh mesh;
  double moved = 0;  // how far a vertex has at most
};
std::optional<ClosedScan> close_cracks(const ScannedSurface& scan, const PlanBox& domain,
                                       double width, double loose_width);

}  // namespace diesink
