// The regions of the die triangulated in the charts of their faces, sharing the points of the arcs
// between them. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "core/tessellate/arc_samples.h"
#include "core/tessellate/planar_triangulation.h"
#include "core/tessellate/search_budget.h"

namespace diesink {

struct RegionMesh {
  Label label = kNoLabel;
  std::uint32_t region = 0;
  // Local vertices: the first are arc points in the order of `arc_point`; where that is
  // ArcSamples::kNone the vertex is inside, and its place is in `inner`.
  std::vector<std::uint32_t> arc_point;
  std::vector<Vec3> position;
  std::vector<double> border_bound;  // of a vertex: largest bound of the chords that end there
  std::vector<std::array<std::uint32_t, 3>> triangles;
  // Of the face too, but upright: pieces of its body's wall. Deviations count here as there.
  std::vector<std::array<std::uint32_t, 3>> upright;
  // Empty, or the normals that each triangle's corners have; else those of the face's chart.
  std::vector<Vec3> normals;
  std::vector<std::array<std::uint32_t, 3>> corner_normals;
  std::vector<std::vector<std::uint32_t>> creases;  // inside the region: chains of local vertices
  double largest_deviation = 0;                     // chords counted
  double unproven_area = 0;            // in plan, of triangles without a bound within the tolerance
  Vec3 unproven_place = Vec3::Zero();  // the middle of the first of them
};

struct RegionOptions {
  double tolerance = 0;
  double min_angle = 0.40;   // radians in the chart
  double flat_angle = 0.21;  // on planes, where only the grading beside fine borders asks for any
  double shortest = 0;
  double least_altitude = 0;      // of a triangle that has area
  double largest_coordinate = 0;  // of the finished mesh, if it is moved: vertices will round to it
  int rounds = 24;
  int threads = 0;
  bool floor = false;  // of a solid: chords beside no surface must not cross in plan either
  std::size_t crossings = SearchBudget().crossings;
  // A region that cannot be triangulated in its chart is triangulated in plan, and all others are
  // refined however that ends: their arcs then have what they need.
  bool to_the_end = false;
  bool skip_base = false;  // a scanned base is not a face with a chart
  const std::vector<double>* grid_x =
      nullptr;  // both set: the grid's nodes instead of refinement, in plan
  const std::vector<double>* grid_y = nullptr;
};

// Triangulates all regions that have a surface; splits arcs where both sides need it.
// Errors: kInput (our own failure told as such) where a region's border cannot be triangulated.
Result<std::vector<RegionMesh>> mesh_regions(const CompoundSurface::Impl& surface,
                                             const Arrangement& arrangement, ArcSamples& samples,
                                             const RegionOptions& options);

}  // namespace diesink
