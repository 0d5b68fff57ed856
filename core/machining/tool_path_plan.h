// Tool paths for a compound surface: what is asked, what comes out.
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

enum class PathPattern : std::uint8_t { kZigzag, kOneway };
enum class PathMethod : std::uint8_t { kDrop, kCc };
enum class PathAlong : std::uint8_t { kAngle, kU, kV };  // kU, kV: curves of a Ferguson base

// A cutter contact point and the unit normal there.
struct CcContact {
  Vec3 p = Vec3::Zero();
  Vec3 n = Vec3::UnitZ();
};

// Units: the part program's; angles in radians from the x axis.
struct PathOptions {
  Cutter cutter;
  PathMethod method = PathMethod::kDrop;
  PathPattern pattern = PathPattern::kZigzag;
  PathAlong along = PathAlong::kAngle;
  double angle = 0;
  std::optional<double> interval;   // between passes in plan; else from `cusp`
  std::optional<double> cusp;       // cusp height
  double intol = 0, outtol = 0;     // overcut and undercut; their sum must be positive
  std::optional<double> clearance;  // height of rapid moves; default a diameter above the surface
  bool keep_interference = false;   // cc only: leave the loops in, to look at
  int threads = 0;                  // 0 = all cores
  // Called now and then with the part done, 0..1, from any thread; may be empty.
  std::function<void(double)> progress;
  // Method cc: called with the CC-data of each stretch of a pass, in the order they are cut; may be
  // empty.
  std::function<void(std::span<const CcContact>)> cc_pass;
};

// The options as the part program states them; the cutter's diameter is 0 where it states none.
PathOptions path_options_of(const PartProgram& program);

// Whether passes this far apart can be planned over the domain. Needs: the cutter's diameter.
// Errors: kInput for an interval or a cusp height that is missing or wrong for the cutter; kLimit
// for more than ten million passes.
Status check_spacing(const PathOptions& options, const Machining& machining);

struct PathReport {
  std::size_t passes = 0, points = 0;
  double feed_length = 0, rapid_length = 0;
  double least_interval = 0, greatest_interval = 0;
  std::size_t added_runs = 0;  // put in between passes, where they would leave too much
  std::size_t wall_runs = 0;   // along the feet of walls
  // In plan, where what stays between passes could not be bounded, or nothing looked at it, or at
  // points too far apart.
  double unsettled_area = 0;
  std::size_t closing_runs = 0;  // over what was seen to stay too high between passes
  // Where the cutter fits and more than OUTTOL and the cusp height stays: the plan area and the
  // most that does, seen on a lattice of this spacing; 0 spacing where the passes bound it by
  // themselves.
  double left_area = 0, left_height = 0, left_spacing = 0;
  double overcut_bound = 0;   // no move goes deeper into the true surface than this
  double undercut_bound = 0;  // no move stays higher over the lowest safe tip than this; drop only
  double mesh_deviation = 0;  // of the mesh the cutter was dropped on
  double uncertified_area = 0;    // of that mesh: there the bounds are not proven
  // Plan area where this cutter, its axis in the domain, leaves more than OUTTOL, or two fifths of
  // OUTTOL and the cusp height if that is less, wherever it stands: proven for the surface where
  // the cusp height is given, and of what the moves leave higher than OUTTOL and it; all that is
  // neither proven to keep that nor in left_area or unsettled_area. With an interval, seen at
  // points.
  double unreachable_area = 0;
  // Of that, strips along its border where the cutter leaves less but holds what stands there no
  // deeper than may stay, or less than half of it, are in; and this, where no place for the cutter
  // was found, nor proven that there is none.
  double unproven_area = 0;
  double unreachable_height = 0;  // the most it must leave there, to the spacing of the examination
  std::size_t loops_removed = 0, crossings_inserted = 0;  // cc only: Fig. 12
};

struct PlannedPath {
  ToolPath path;
  PathReport report;
  std::vector<std::vector<CcContact>> cc_passes;  // method cc: the CC-data of each stretch
};

// Plans the finishing path over the program's domain and hands it to `receiver` as it comes. The
// cutter's centre stays in the domain; material around it counts wherever the surface is defined.
// Rapid moves run at the clearance plane, or straight up to it; every move down is at feed. Where
// the cusp height is given, passes are put in wherever two passes would leave more than it and
// OUTTOL, and along the feet of walls; a given interval is kept as it is.
// Errors: those of check_spacing(); kInput for a wrong cutter or tolerance, a clearance plane below
//         the surface, a surface the cutter never meets, kU, kV without a Ferguson base; what the
//         tessellator and the receiver return. Nothing is handed over before the path is known not
//         to be empty.
// Same points for any thread count. Memory: the mesh and its offset surface, a few passes, and the
// runs put in that are not yet cut; where the cusp height is given, the moves, for the proof of
// what stays.
Result<PathReport> plan_path(const CompoundSurface& surface, const PathOptions& options,
                             PathReceiver& receiver);

// The same, held whole.
Result<PlannedPath> plan_path(const CompoundSurface& surface, const PathOptions& options);

// The drop method on a mesh of the surface, known to be at most `deviation` away from it.
// `domain` is x0, x1, y0, y1. The mesh should reach a cutter's radius beyond it. `head` gives the
// path's name, unit, feed and spindle. A flat end's contact does not bound what stays between
// passes:
// where its `surface` is given, that is seen on a lattice and runs are put in.
Result<PathReport> plan_drop_path(const TriangleMesh& mesh, double deviation,
                                  const std::array<double, 4>& domain, const PathOptions& options,
                                  ToolPath head, PathReceiver& receiver,
                                  const CompoundSurface* surface = nullptr);
Result<PlannedPath> plan_drop_path(const TriangleMesh& mesh, double deviation,
                                   const std::array<double, 4>& domain, const PathOptions& options);

// The paper's method: CC-data along each pass, equation (6), interferences removed (Fig. 12). The
// mesh proves that no move gouges: the height the cutter may not go below is known along the whole
// of each move, and points are put in until none dips deeper than INTOL under it.
Result<PathReport> plan_cc_path(const CompoundSurface& surface, const TriangleMesh& mesh,
                                double deviation, const PathOptions& options, ToolPath head,
                                PathReceiver& receiver);
Result<PlannedPath> plan_cc_path(const CompoundSurface& surface, const TriangleMesh& mesh,
                                 double deviation, const PathOptions& options);

}  // namespace diesink
