// From a compound surface to a triangle mesh with sharp element boundaries and a certified
// deviation. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/compound/compound_surface.h"
#include "core/mesh.h"
#include "core/result.h"
#include "core/tessellate/search_budget.h"
#include "core/tessellate/tile_cuts.h"

namespace diesink {

enum class MeshScheme : std::uint8_t { kAdaptive, kGrid };

struct TessellationOptions {
  MeshScheme scheme = MeshScheme::kAdaptive;
  bool creases = true;          // grid only: insert the edge points
  double tolerance = 0;         // 0 = the program's
  bool solid = false;           // close with skirts and a floor
  std::optional<double> floor;  // height of the floor; default below the lowest point
  double feature_angle = 30;    // degrees: edges of a scanned base that turn by more are creases
  std::array<int, 2> tiles{1, 1};
  std::array<int, 2> tile{0, 0};  // which tile to make
  // Of all tiles, as tile_cuts() gives them: whoever makes many saves finding them anew for each.
  // Not owned; may be null.
  const TileCuts* cuts = nullptr;
  int threads = 0;      // 0 = all cores
  SearchBudget budget;  // places that take more are told, not certified
  // Called now and then with the part done, 0..1, from any thread; may be empty.
  std::function<void(double)> progress;
};

struct ElementReport {
  std::string name, solid, type;  // "S2.side", "S2", "R-CYLI"; skirts and floor have type ""
  int sign = 1;
  std::size_t triangles = 0;
  double area = 0;
  double max_deviation = 0;  // certified
};

struct CurveReport {
  CurveKind kind = CurveKind::kCrease;
  std::array<std::string, 2> between;
  double length = 0;
  bool closed = false;
};

// A place that is not certified: what the arrangement or a region gave up, or what the last check
// of the finished mesh could not confirm (last_check.h).
struct MeshDoubt {
  Vec3 place = Vec3::Zero();
  std::string element;  // of the triangle there; empty where there is none
  std::string what;
  double area = 0;  // in plan, part of uncertified_area
};

struct TessellationReport {
  static constexpr std::size_t kMostDoubts = 8;
  std::size_t crease_vertices = 0, jump_vertices = 0, corner_vertices = 0;
  double tolerance = 0;
  double certified_deviation = 0;  // a bound, not a sample
  double uncertified_area = 0;     // plan area whose features or deviation could not be certified
  // How far creases of a scanned base may lie off its own triangles: in space where cracks between
  // those were closed, along vertical lines where the scan had to be thinned out before the curves
  // were found. 0 where they lie on them, to 1e-9 of the size.
  double crease_offset = 0;
  double area = 0, volume = 0;  // volume under the surface down to the floor or the lowest z
  bool watertight = false;
  std::array<double, 4> domain{0, 0, 0, 0};
  std::array<Vec3, 2> bounds{Vec3::Zero(), Vec3::Zero()};
  std::vector<ElementReport> elements;
  std::vector<CurveReport> curves;
  std::vector<MeshDoubt> doubts;  // the first kMostDoubts of them
  std::size_t doubt_count = 0;
  double seconds_evaluate = 0, seconds_tessellate = 0;

  // How far the mesh may be from the surface outside uncertified_area: at a place of that it may be
  // further off than any tolerance, which says nothing of the rest.
  [[nodiscard]] double deviation_where_certified() const {
    return uncertified_area > 0 ? std::fmin(certified_deviation, tolerance) : certified_deviation;
  }
  // Counts a place into uncertified_area, and names it where there are not too many; one without
  // area is none.
  void add_doubt(const Vec3& place, std::string element, std::string what, double area_there) {
    if (!(area_there > 0)) return;
    uncertified_area += area_there;
    ++doubt_count;
    if (doubts.size() < kMostDoubts)
      doubts.push_back({place, std::move(element), std::move(what), area_there});
  }
};

struct Tessellation {
  TriangleMesh mesh;  // with elements, normals split at creases, and curves
  TessellationReport report;
};

// Same bytes for any thread count. Each tile is made without the others: its mesh ends at a cut in
// the chain of vertices that its neighbour's ends in, to the bit. A tile without a surface is an
// empty mesh. Solid tiles are closed blocks; without `floor` all stand on one, below everything the
// program names.
// Errors: kInput for an empty surface (of a domain in one tile), a grid over the limits or a
// tolerance below 4e-12 of the largest coordinate; kLimit
// for too many triangles;
//         kUnsupported for a MESH base where a grid with creases is asked for.
Result<Tessellation> tessellate(const CompoundSurface& surface, const TessellationOptions& options);

}  // namespace diesink
