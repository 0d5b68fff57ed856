// CC-data as CSV and JSON: the grid array, lists of points, and the pairs on either side of edges.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "core/grid/edges.h"
#include "core/grid/grid_array.h"
#include "formats/byte_sink.h"

namespace diesink {

// A plan point and what lies over it.
struct CcPoint {
  double x = 0, y = 0;
  std::optional<CcDatum> datum;  // empty where there is no surface
};

// Header x,y,z,nx,ny,nz,surface,row,face; one line a point, the grid's in row-major order. Numbers
// in the shortest form that reads back the same double; a point without a surface has empty fields
// after y. surface: 0 the base, k the k-th solid of the program; row: of the Boolean table, from 0;
// face: 0 on the base.
// Errors: those of the sink.
Status write_cc_csv(const CompoundSurface& surface, const GridArray& grid, ByteSink& sink);
Status write_cc_csv(std::span<const CcPoint> points, ByteSink& sink);

// One object: unit, names (the id of every surface number), for a grid its x and y lines, and
// `points`, an array of objects with the CSV's fields; null where the CSV's field is empty.
Status write_cc_json(const CompoundSurface& surface, const GridArray& grid, ByteSink& sink);
Status write_cc_json(const CompoundSurface& surface, std::span<const CcPoint> points,
                     ByteSink& sink);

// Edge pairs, one line a pair: kind (crease, edge, jump), then the fields above of either side, the
// second with a 2 behind the name. The side without a surface has empty fields after its y.
Status write_edges_csv(std::span<const EdgePair> edges, ByteSink& sink);
// One object: unit, names, `edges`: an array of {"kind", "first": {...}, "second": {...}}.
Status write_edges_json(const CompoundSurface& surface, std::span<const EdgePair> edges,
                        ByteSink& sink);

}  // namespace diesink
