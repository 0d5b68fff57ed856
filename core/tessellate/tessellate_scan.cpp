// The scan's top layer takes the scan's place: triangles of which no two lie over one another. The
// arcs between it and the solids are found over the layer as it is, so that their points lie on the
// scan's own facets; then it is cut along them and what is seen of it is thinned out, and the
// points of the arcs with it. Both are flat piece by piece: how far one is from the other is
// measured, not sampled.
// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/tessellate_scan.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

#include "core/base/scan_cracks.h"
#include "core/base/scan_sheet.h"
#include "core/base/scan_thin.h"
#include "core/compound/compound_impl.h"
#include "core/tessellate/arc_samples.h"
#include "core/tessellate/arrangement.h"
#include "core/tessellate/assemble.h"
#include "core/tessellate/home.h"
#include "core/tessellate/last_check.h"
#include "core/tessellate/mesh_report.h"
#include "core/tessellate/plain_grid.h"
#include "core/tessellate/region_mesh.h"
#include "core/tessellate/scan_arcs.h"
#include "core/tessellate/scan_mesh.h"
#include "core/tessellate/seam.h"
#include "core/tessellate/untangle.h"

namespace diesink {
namespace {

// Of what the sheet leaves of the tolerance: what the chords of arcs may take.
constexpr double kArcShare = 0.35;
// Of that: what is left of it when points of the arcs have gone again.
constexpr double kMostSag = 1.2;
// Of the tolerance: what the base may use even where chords leave it less.
constexpr double kLeastSheetShare = 0.25;

// Of the tolerance: how far off the scan its triangles may be where edges gave way to chords.
constexpr double kMostOffSheet = 0.1;

// Cells of the arrangement for the solids, and eight more a triangle of the sheet: a closed body in
// place of a scan may ask for many more, for upright walls that meet solids upright.
// (Not more than kMostInOne in one piece: the search of an assembly of thousands of walls shall
// end. The first way widens the least cells then.)
constexpr std::size_t kMostCells = 100'000, kMostInOne = 300'000;

// Facets beside walls ask for more cells than the curves of a die do: with wider least cells a
// scanned engine took four times as long and told five times as much.
constexpr std::size_t kMoreCells = 4;

// Ways through. Where borders come closer to one another than can be told apart, other cells may
// do, or a sheet thinned out beforehand (creases then lie on that one's facets).
struct Way {
  double lean;    // of the tolerance: the width in plan of what stands for an upright wall
  int variant;    // of the arrangement's cells
  double before;  // of the tolerance: what the sheet is thinned by first
  double cracks;  // of the tolerance: gaps and overlaps between facets that are closed
};
// (Of rounding always; as wide as stitching leaves them only where nothing else goes, or where most
// facets are by themselves.)
constexpr double kRounding = 1e-3, kStitching = 0.3;
constexpr Way kWays[] = {{0.15, 0, 0, kRounding},
                         {0.1, 1, 0, kRounding},
                         {0.05, 2, 0, kRounding},
                         {0.1, 0, 0.3, kStitching},
                         {0.02, 3, 0.45, kStitching}};
// What the wall under a rim looks like is the same in all tiles.
constexpr Way kTileWays[] = {{0.1, 0, 0, kRounding},
                             {0.1, 1, 0, kRounding},
                             {0.1, 2, 0, kRounding},
                             {0.1, 0, 0.3, kRounding},
                             {0.1, 3, 0.45, kRounding}};
// Of the plan, and of what the sheet itself leaves unproven, which no other way does much better:
// where more is not certified the other ways are tried, too.
constexpr double kToldArea = 1e-9, kToldBesideSheet = 0.25;
// Of the size: no farther off a crease still counts as on the scan.
constexpr double kExact = 1e-9;
// Of the grain by which untangle() moves nodes: what lay on a vertex or an edge of the sheet is no
// farther off afterwards.
constexpr double kChordReach = 2;
// Of the tolerance: what a seam between tiles leaves the chords and faces beside it, whatever the
// sheets of the two have taken. (No sheet takes more than kWays has, but for what it moves.)
constexpr double kSeamShare = 0.3;

// The same surface over a mesh in place of the scan.
Result<CompoundSurface> over_mesh(const CompoundSurface& surface, TriangleMesh mesh) {
  PartProgram program = surface.program();
  MeshBase& base = std::get<MeshBase>(program.base);
  base.placement.clear();
  base.fill_size = 0;
  base.smooth_normals = false;
  return CompoundSurface::make(program, std::move(mesh));
}

Result<CompoundSurface> over_sheet(const CompoundSurface& surface, const ScanSheet& sheet) {
  TriangleMesh mesh;
  mesh.positions = sheet.points;
  mesh.triangles = sheet.triangles;
  return over_mesh(surface, std::move(mesh));
}

// The border of the sheet on a cut between tiles: pieces from low to high along the cut, ascending.
std::vector<std::array<Vec3, 2>> profile_on(const ScanSheet& sheet, int axis, double at) {
  std::vector<std::array<Vec3, 2>> pieces;
  const int along = 1 - axis;
  for (std::uint32_t h = 0; h < sheet.twin.size(); ++h) {
    if (sheet.twin[h] != ScanSheet::kNone) continue;
    Vec3 p = sheet.points[sheet.from(h)], q = sheet.points[sheet.to(h)];
    if (p[axis] != at || q[axis] != at) continue;
    if (p[along] > q[along]) std::swap(p, q);
    pieces.push_back({p, q});
  }
  std::sort(pieces.begin(), pieces.end(),
            [&](const auto& a, const auto& b) { return a[0][along] < b[0][along]; });
  return pieces;
}

// A base must be somewhere: where a domain within `reach` of the origin does not see it.
ScanSheet sheet_elsewhere(double reach) {
  const double far = 4 * reach + 1;
  ScanSheet sheet;
  sheet.points = {{far, far, 0}, {far + 1, far, 0}, {far, far + 1, 0}};
  sheet.triangles.push_back({0, 1, 2});
  sheet.twin.assign(3, ScanSheet::kNone);
  return sheet;
}

// The seam of a tile over a scan. Along the cut the scan is the border of its sheet, which both
// tiles have to the bit; a base that looks like it everywhere across the domain takes its place, so
// that nothing depends on what either tile has made of the scan beside the cut.
Result<Seam> scan_seam(const CompoundSurface& original, const ScanSheet& sheet, int axis, double at,
                       double from, double to, SeamOptions options) {
  const std::vector<std::array<Vec3, 2>> pieces = profile_on(sheet, axis, at);
  ScanSheet ruled;
  const double low = axis == 0 ? options.domain.x0 : options.domain.y0;
  const double high = axis == 0 ? options.domain.x1 : options.domain.y1;
  options.profile.clear();
  for (const auto& piece : pieces) {
    const auto first = static_cast<std::uint32_t>(ruled.points.size());
    for (const Vec3& p : piece) {
      for (const double side : {low, high}) {
        ruled.points.push_back(p);
        ruled.points.back()[axis] = side;
      }
      options.profile.emplace_back(p[1 - axis], p.z());
    }
    const std::uint32_t a = first, b = first + 1, c = first + 2, d = first + 3;
    ruled.triangles.push_back({a, b, d});
    ruled.triangles.push_back({a, d, c});
  }
  if (pieces.empty()) ruled = sheet_elsewhere(original.size());
  Result<CompoundSurface> surface = over_sheet(original, ruled);
  if (!surface) return surface.error();
  return make_seam(surface->impl(), axis, at, from, to, options);
}

// The largest absolute coordinate of the domain.
double reach_of(const CompoundSurface& surface) {
  const Machining& m = surface.program().machining;
  return std::fmax(std::fmax(std::fabs(m.x_range[0]), std::fabs(m.x_range[1])),
                   std::fmax(std::fabs(m.y_range[0]), std::fabs(m.y_range[1])));
}

Error nothing_there(const CompoundSurface& surface) {
  return {
      ErrorCode::kInput, "no triangle of the scan lies in the domain", {surface.program().file}};
}

// The faces between the arcs, the base first.
struct Faces {
  std::vector<RegionMesh> meshes;
  double base_bound = 0;  // of the base: off the sheet along vertical lines
};

struct FaceOptions {
  RegionOptions regions;
  ThinOptions thin;
  double sag = 0;  // of the arcs
};

Result<Faces> mesh_faces(const CompoundSurface& surface, const ScanSheet& sheet,
                         const Arrangement& arrangement, const ScanArcs& arcs, ArcSamples& samples,
                         FaceOptions options) {
  const double budget = options.regions.tolerance, most_sag = kMostSag * options.sag;
  Result<ScanCut> cut =
      cut_sheet(surface.impl(), arrangement, samples, sheet, arcs, kMostOffSheet * budget);
  if (!cut) return cut.error();
  options.thin.tolerance =
      std::fmax(kLeastSheetShare * budget,
                budget - cut->off_sheet - std::fmax(most_sag, largest_bound(samples, *cut)));
  Faces faces;
  faces.base_bound = cut->off_sheet + thin_cut(*cut, arrangement, samples, options.thin, most_sag);
  Result<std::vector<RegionMesh>> regions =
      mesh_regions(surface.impl(), arrangement, samples, options.regions);
  if (!regions) return regions.error();
  faces.meshes = std::move(*regions);
  RegionMesh base = mesh_base(samples, *cut, options.thin.feature_angle);
  base.largest_deviation += faces.base_bound;
  if (!base.triangles.empty()) faces.meshes.insert(faces.meshes.begin(), std::move(base));
  return faces;
}

PlanBox domain_of(const CompoundSurface& surface) {
  const Machining& machining = surface.program().machining;
  return {machining.x_range[0], machining.x_range[1], machining.y_range[0], machining.y_range[1]};
}

// What one way through says of the others.
struct Outlook {
  bool may_differ = false;  // another may do where it fails, or do better
  bool too_fine = false;    // the scan asks for more cells than there may be, widened or not
};

// `closed`: how far vertices of the scan have moved before.
Result<Tessellation> attempt(const CompoundSurface& original, double closed, const PlanBox& box,
                             const TessellationOptions& options, const Way& way, Outlook& outlook) {
  outlook = {};
  const double tolerance =
      options.tolerance > 0 ? options.tolerance : original.program().machining.tolerance;
  const double feature_angle = options.feature_angle * (std::numbers::pi / 180);
  auto start = std::chrono::steady_clock::now();
  const auto tell = [&](double part) {
    if (options.progress) options.progress(part);
  };

  ScanSheet sheet = top_sheet(std::get<ScannedSurface>(original.impl().base), box,
                              way.lean * tolerance, options.threads);
  const bool tiled = options.tiles != std::array{1, 1};
  if (sheet.triangles.empty() && tiled && original.program().solids.empty()) return empty_tile(box);
  // The whole domain is a hole: what solids there are is meshed.
  if (sheet.triangles.empty() && original.program().solids.empty()) return nothing_there(original);
  if (sheet.triangles.empty()) sheet = sheet_elsewhere(reach_of(original));
  ThinOptions thin;
  thin.feature_angle = feature_angle;
  thin.box = box;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    thin.fixed_side[2 * axis] = options.tile[axis] > 0;
    thin.fixed_side[2 * axis + 1] = options.tile[axis] + 1 < options.tiles[axis];
  }
  const CompoundSurface::Impl& impl = original.impl();
  SeamOptions seam_options;
  seam_options.domain = domain_of(original);
  seam_options.tolerance = kSeamShare * tolerance;
  seam_options.sag = kArcShare * seam_options.tolerance;
  seam_options.shortest = std::fmax(0.5 * tolerance, 1e-9 * impl.size);
  seam_options.search = {flat_height(impl, tolerance),
                         std::ldexp(std::fmax(seam_options.domain.x1 - seam_options.domain.x0,
                                              seam_options.domain.y1 - seam_options.domain.y0),
                                    -22),
                         kUnseen * tolerance, 0.25 * tolerance, options.budget.pieces};
  std::array<std::optional<Seam>, 4> seams;
  const TileSides sides(box, options, border_inset(impl));
  for (std::size_t side = 0; side < 4; ++side) {
    if (!sides.cut[side]) continue;
    Result<Seam> seam = scan_seam(original, sheet, TileSides::axis(side), sides.at[side],
                                  sides.from[side], sides.to[side], seam_options);
    if (!seam) return seam.error();
    seams[side] = std::move(*seam);
  }
  // What stands for the scan differs from it by that along vertical lines; so does the whole die,
  // as max and min keep bounds on heights.
  double crease_offset = closed, moved = sheet.moved + closed;
  if (way.before > 0) {
    thin.tolerance = way.before * tolerance;
    const double thinned = thin_sheet(sheet, thin);
    crease_offset += thinned;
    moved += thinned;
  }
  if (crease_offset <= kExact * impl.size) crease_offset = 0;
  Result<CompoundSurface> made_surface = over_sheet(original, sheet);
  if (!made_surface) return made_surface.error();
  const CompoundSurface& surface = *made_surface;
  tell(0.2);

  ArrangementOptions arrangement_options;
  arrangement_options.tolerance = tolerance;
  arrangement_options.threads = options.threads;
  arrangement_options.least = std::ldexp(std::fmax(box.x1 - box.x0, box.y1 - box.y0), -22);
  arrangement_options.variant = way.variant;
  arrangement_options.budget = options.budget;
  arrangement_options.budget.cells *= kMoreCells;
  arrangement_options.most_cells = kMostCells + 8 * sheet.triangles.size();
  arrangement_options.may_widen = !tiled && &way == kWays;
  if (!tiled) arrangement_options.most_cells = std::min(arrangement_options.most_cells, kMostInOne);
  arrangement_options.budget.added =
      std::min(options.budget.added, arrangement_options.most_cells / 4);
  for (std::size_t side = 0; side < 4; ++side) {
    if (seams[side]) arrangement_options.seams[side] = &*seams[side];
  }
  Result<Arrangement> arrangement = arrange(surface, box, arrangement_options);
  if (!arrangement && tiled && arrangement.error().code == ErrorCode::kInput)
    return empty_tile(box);
  if (!arrangement) {
    outlook.may_differ = outlook.too_fine = arrangement.error().code == ErrorCode::kLimit;
    return arrangement.error();
  }
  outlook.too_fine = arrangement->widened;
  if (!arrangement->keeps_seams) {
    outlook.may_differ = true;
    return Error{ErrorCode::kInput,
                 "a cut between tiles runs along what cannot be told apart at the least distance",
                 {original.program().file}};
  }
  ScanArcs arcs = cut_arcs(surface.impl(), sheet, arrangement_options.least, *arrangement);
  const double evaluate = seconds_since(start);
  start = std::chrono::steady_clock::now();
  tell(0.4);

  // Faces of solids and the arcs have the whole of it, the base what its arcs leave.
  const double budget = (tolerance - moved) * (1 - 1e-6) - 4 * surface.tie_tolerance();
  SamplingOptions sampling;
  sampling.sag = sampling.flat_sag = kArcShare * budget;
  sampling.tolerance = budget;
  sampling.shortest = std::fmax(0.5 * tolerance, 1e-9 * surface.size());
  std::optional<ArcSamples> samples;
  samples.emplace(surface.impl(), *arrangement, sampling);
  samples->sample_all(options.threads);
  tell(0.5);
  outlook.may_differ = true;

  FaceOptions face_options;
  face_options.thin = thin;
  face_options.sag = sampling.sag;
  face_options.regions.tolerance = budget;
  face_options.regions.shortest = sampling.shortest;
  face_options.regions.least_altitude = least_altitude(surface);
  face_options.regions.threads = options.threads;
  face_options.regions.skip_base = true;
  Result<Faces> faces = mesh_faces(surface, sheet, *arrangement, arcs, *samples, face_options);
  if (!faces) {
    // Thinning has left points of arcs out: without those chords would not follow the facets.
    samples.emplace(surface.impl(), *arrangement, sampling);
    samples->sample_all(options.threads);
    std::optional<Arrangement> chords = untangle(surface.impl(), *arrangement, *samples, 0);
    if (!chords) return faces.error();
    samples.reset();
    *arrangement = std::move(*chords);
    arcs =
        place_chords(surface.impl(), sheet, arcs, kChordReach * arrangement->grain, *arrangement);
    samples.emplace(surface.impl(), *arrangement, sampling);
    samples->sample_all(options.threads);
    face_options.regions.to_the_end = true;
    faces = mesh_faces(surface, sheet, *arrangement, arcs, *samples, face_options);
  }
  if (!faces) return faces.error();
  const std::vector<RegionMesh>& regions = faces->meshes;
  tell(0.9);

  Result<Tessellation> made = assemble(surface, *arrangement, *samples, regions, options);
  if (!made) {
    double lowest = HUGE_VAL;
    for (const RegionMesh& r : regions) {
      for (const Vec3& p : r.position) lowest = std::fmin(lowest, p.z());
    }
    outlook.may_differ = !options.floor || *options.floor < lowest;
    return made.error();
  }
  TessellationReport& report = made->report;
  report.tolerance = tolerance;
  report.crease_offset = crease_offset;
  report.certified_deviation = samples->largest_deviation;
  for (ElementReport& e : report.elements) {
    if (e.max_deviation > 0) e.max_deviation += moved;  // walls know their chords'
  }
  for (const RegionMesh& r : regions) {
    report.certified_deviation = std::fmax(report.certified_deviation, r.largest_deviation);
    const std::string name = surface.element_name(r.label);
    for (ElementReport& e : report.elements) {
      if (e.name == name) e.max_deviation = std::fmax(e.max_deviation, r.largest_deviation + moved);
    }
  }
  report.certified_deviation += moved;
  add_doubts(surface, *arrangement, *samples, regions, report.certified_deviation, report);
  // Of what has no place of its own.
  report.uncertified_area +=
      sheet.unproven_area + arcs.unsolved_length * 2 * report.certified_deviation;
  last_check(original, options.threads, *made);
  outlook.may_differ =
      report.uncertified_area - sheet.unproven_area >
      kToldArea * (box.x1 - box.x0) * (box.y1 - box.y0) + kToldBesideSheet * sheet.unproven_area;
  report.seconds_evaluate = evaluate;
  report.seconds_tessellate = seconds_since(start);
  tell(1);
  return made;
}

}  // namespace

Result<CompoundSurface> seen_surface(const CompoundSurface& surface, const PlanBox& domain,
                                     double tolerance, int threads) {
  ScanSheet sheet = top_sheet(std::get<ScannedSurface>(surface.impl().base), domain,
                              kWays[0].lean * tolerance, threads);
  if (sheet.triangles.empty() && surface.program().solids.empty()) return nothing_there(surface);
  if (sheet.triangles.empty()) sheet = sheet_elsewhere(reach_of(surface));
  return over_sheet(surface, sheet);
}

Result<Tessellation> tessellate_scan(const CompoundSurface& surface, const PlanBox& box,
                                     const TessellationOptions& options) {
  std::optional<Error> first;
  std::optional<Tessellation> best;  // of those not certified all over
  const bool tiled = options.tiles != std::array{1, 1};
  bool limit = false;  // too many cells for the scan as it is, in any of the ways
  const double tolerance =
      options.tolerance > 0 ? options.tolerance : surface.program().machining.tolerance;
  // The scan with its cracks closed as the last way asked for; as it is where none were.
  std::optional<CompoundSurface> whole;
  double width = 0, closed = 0;  // of the cracks; how far a vertex has moved
  for (const Way& way : tiled ? kTileWays : kWays) {
    if (way.before == 0 ? limit : best.has_value()) continue;
    if (way.cracks != width) {
      width = way.cracks;
      whole.reset();
      closed = 0;
      if (std::optional<ClosedScan> scan =
              close_cracks(std::get<ScannedSurface>(surface.impl().base), domain_of(surface),
                           width * tolerance, kStitching * tolerance)) {
        Result<CompoundSurface> over = over_mesh(surface, std::move(scan->mesh));
        if (!over) return over.error();
        whole.emplace(std::move(*over));
        closed = scan->moved;
      }
    }
    Outlook outlook;
    Result<Tessellation> made =
        attempt(whole ? *whole : surface, closed, box, options, way, outlook);
    if (!outlook.may_differ) return made;
    if (made && (!best || made->report.uncertified_area < best->report.uncertified_area))
      best.emplace(std::move(*made));
    limit = limit || outlook.too_fine;
    if (!made && !first) first = made.error();
  }
  if (best) return std::move(*best);
  // Nothing proved: the grid tells so itself.
  TessellationOptions plain = options;
  plain.solid = false;
  Result<Tessellation> made = mesh_plain_grid(surface, box, plain);
  return made ? std::move(made) : Result<Tessellation>(*first);
}

}  // namespace diesink
