// The visible part of a scanned base as triangles: cut along the arcs, then thinned out.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/scan_sheet.h"
#include "core/base/scan_thin.h"
#include "core/tessellate/arc_samples.h"
#include "core/tessellate/region_mesh.h"
#include "core/tessellate/scan_arcs.h"

namespace diesink {

// The sheet with the chords of the arcs beside the base among its edges: the same surface but for
// their sag within single triangles, what is hidden included.
struct ScanCut {
  ScanSheet sheet;
  std::vector<std::uint32_t> arc_point;  // of each vertex, or ArcSamples::kNone
  std::vector<char> base;                // of each triangle: whether it is seen
  Label label = kNoLabel;                // of the base; kNoLabel where nothing of it is seen
  // Of triangles whose edges had to give way to others: how far they are off the sheet along
  // vertical lines, and the plan area of those that are too far.
  double off_sheet = 0, unproven_area = 0;
  std::vector<ArcUse> uses;  // the arcs with the base on their left
};

// Needs: arcs cut by cut_arcs() and sampled; every arc point on an edge of the sheet is a node;
//        a surface over the sheet. most_off: what off_sheet may be.
// Errors: kInput (our own failure told as such) where the borders cannot be triangulated.
Result<ScanCut> cut_sheet(const CompoundSurface::Impl& surface, const Arrangement& arrangement,
                          const ArcSamples& samples, const ScanSheet& sheet, const ScanArcs& arcs,
                          double most_off);

// Leaves what is seen and thins it; points of arcs go too, where the arc stays within `sag` of what
// is left, and are dropped from the samples. Returns the largest vertical distance between what is
// left and the sheet, hidden parts included.
double thin_cut(ScanCut& cut, const Arrangement& arrangement, ArcSamples& samples,
                ThinOptions options, double sag);

// The largest bound of the chords round the base.
double largest_bound(const ArcSamples& samples, const ScanCut& cut);

// The base as a mesh, with normals split at its creases: edges that turn by more than the feature
// angle, radians. Its deviation is that of the chords alone.
RegionMesh mesh_base(const ArcSamples& samples, const ScanCut& cut, double feature_angle);

}  // namespace diesink
