// The arcs beside a scanned base cut where they pass from triangle to triangle of it, so that every
// stretch lies in one plane of the base.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/scan_sheet.h"
#include "core/tessellate/arrangement.h"

namespace diesink {

// Where a plan point lies on a sheet.
struct ScanPlace {
  enum class Kind : std::uint8_t { kUnknown, kTriangle, kEdge, kVertex } kind = Kind::kUnknown;
  std::uint32_t id = 0;  // triangle; half-edge, of a pair the one with the lower number; vertex
};

// What the arcs have to do with the sheet.
struct ScanArcs {
  std::vector<ScanPlace> place;        // of each plan node; unknown for nodes away from the base
  std::vector<char> touched;           // triangles that an arc runs through or along
  std::vector<std::uint32_t> node_at;  // of each vertex of the sheet: a node there, or kNone
  double unsolved_length = 0;          // plan length of stretches whose triangle could not be told
};

// True for labels of the base.
bool is_base(const CompoundSurface::Impl& surface, Label label);

// Adds the nodes to the arrangement and names the triangle of each stretch. Nodes on triangle edges
// are kept (PlanNode::kept): the chains of the arcs run through them.
// Needs: a surface whose base is the sheet.
ScanArcs cut_arcs(const CompoundSurface::Impl& surface, const ScanSheet& sheet, double least,
                  Arrangement& arrangement);

// The same for the straight chords that untangle() has made of the arcs: what their nodes lie on.
// Needs: `cut` of the arcs before; reach: how far nodes may have moved in plan.
ScanArcs place_chords(const CompoundSurface::Impl& surface, const ScanSheet& sheet,
                      const ScanArcs& cut, double reach, const Arrangement& chords);

}  // namespace diesink
