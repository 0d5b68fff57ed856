// The visible part of a scanned base as triangles: its own, cut along the arcs.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/scan_sheet.h"
#include "core/tessellate/arc_samples.h"
#include "core/tessellate/region_mesh.h"
#include "core/tessellate/scan_arcs.h"

namespace diesink {

struct ScanMeshOptions {
  double feature_angle = 0;  // radians: edges that turn by more are creases
  double tolerance = 0;
  int threads = 0;
};

// All regions of the base in one mesh, with normals split at its creases. Its triangles lie in
// those of the sheet but for the sag of the arcs' chords. Needs: arcs cut by cut_arcs() and
// sampled; every arc point on an edge of the sheet is a node. Errors: kInput (our own failure told
// as such) where the borders cannot be triangulated.
Result<RegionMesh> mesh_scan(const CompoundSurface::Impl& surface, const Arrangement& arrangement,
                             const ArcSamples& samples, const ScanSheet& sheet,
                             const ScanArcs& arcs, const ScanMeshOptions& options);

}  // namespace diesink
