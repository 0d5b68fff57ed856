// Checks a tool path, whoever made it, against the compound surface: over the whole swept volume.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "core/compound/compound_surface.h"
#include "core/mesh.h"
#include "core/result.h"
#include "core/tool_path.h"

namespace diesink {

struct VerifyOptions {
  Cutter cutter;
  double intol = 0, outtol = 0;
  double path_deviation = 0;  // of the moves from what they stand for: chords of arcs
  std::optional<double> cusp;
  std::optional<double> spacing;  // of the lattice of cusps; default an eightieth of the diameter
  int threads = 0;                // 0 = all cores
  std::function<void(double)> progress;  // 0..1, from any thread; may be empty
};

// What a lattice point of the domain is; the map's pixels.
enum class CutState : std::uint8_t {
  kNoSurface,    // a hole
  kCut,          // `height` is what stays over the surface, negative where it is gouged
  kUncut,        // reachable, but no move comes over it
  kUnreachable,  // the cutter cannot touch the surface there with its axis in the domain
};

struct VerifyReport {
  double max_gouge = 0;
  Vec3 max_gouge_at = Vec3::Zero();
  double max_excess = 0;  // material left where the cutter fits: the distance to the part, or how
                          // deep a cutter beside a wall could reach into it
  Vec3 max_excess_at = Vec3::Zero();
  // Between the points: in no cell of four points that are cut, and where the cutter could stand if
  // more than the limit stays, does more stay than max_excess + excess_bound, by the distance to
  // the part, as far as moves come over the cell's sixteenths as a whole; `proven_part` of these
  // cells is proven to be within the limit.
  double excess_bound = 0, proven_part = 0;
  double cusp_p50 = 0, cusp_p99 = 0,
         cusp_max = 0;    // over the points that are cut to the limit or better
  double uncut_area = 0;  // plan area, reachable, left higher than the limit or not cut at all
  double limit = 0;       // OUTTOL plus the cusp height, where one is asked for
  double unreachable_area = 0;
  double bound = 0;  // the true largest gouge lies below max_gouge + bound
  std::size_t points = 0;
  double length = 0;              // of the cutting moves
  std::size_t rapid_plunges = 0;  // rapid moves below the surface's top that do not go straight up
  double spacing = 0;             // of the lattice

  // The lattice over the domain, row-major from (x0, y0), x fastest.
  std::size_t columns = 0, rows = 0;
  std::vector<float> height;
  std::vector<CutState> state;
};

// Gives the points of a path; the same every time it is called.
using PathSource = std::function<Status(const PathTaker& take)>;

// Gouges are the depth of the part in the volume that each move sweeps, found over a mesh of the
// surface that is at most `deviation` away from it, whole triangles against whole moves, and at the
// lattice's points on the surface itself. What stays is examined at the lattice's points: the
// distance of the lowest height of the swept volumes from the part, where it is above the limit
// straight up; and bounded between them (excess_bound). Tiny moves are joined
// where that changes no more than 1/256 of both tolerances, which the bounds hold.
// Needs: the mesh reaches a cutter's radius beyond the domain. Errors: kInput for a wrong cutter, a
// path without a move, a spacing that gives too many points; the source's. Same result for any
// thread count. Memory: the lattice and the mesh, whatever the path's length.
Result<VerifyReport> verify_path(const CompoundSurface& surface, const TriangleMesh& mesh,
                                 double deviation, const PathSource& path,
                                 const VerifyOptions& options);
Result<VerifyReport> verify_path(const CompoundSurface& surface, const TriangleMesh& mesh,
                                 double deviation, const ToolPath& path,
                                 const VerifyOptions& options);

}  // namespace diesink
