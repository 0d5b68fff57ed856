// Makes a mesh fit for programs that ask for closed, oriented two-manifolds.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

#include "core/mesh.h"
#include "core/mesh_tools/topology.h"

namespace diesink {

struct RepairOptions {
  double weld = 0;       // vertices this close become one first; 0 = equal positions only
  double max_hole = -1;  // holes whose bounding box has at most this diagonal are filled; 0 = none,
                         // negative = a twentieth of the mesh's own
};

struct RepairReport {
  MeshTopology before;  // after exact welding
  MeshTopology after;   // of the vertices as the repaired mesh shares them
  std::size_t merged_vertices = 0;
  std::size_t removed_degenerate = 0;
  std::size_t removed_duplicates = 0;
  std::size_t flipped = 0;         // triangles turned over
  std::size_t split_edges = 0;     // edges of more than two triangles that were taken apart
  std::size_t split_vertices = 0;  // copies made of vertices where surfaces only touched
  std::size_t filled_holes = 0;
  std::size_t added_triangles = 0;
  std::size_t unorientable =
      0;  // shells with no consistent orientation (one-sided): left as they are
};

// In this order: welds; removes triangles with two equal corners and repeated ones; turns the
// triangles of each shell the same way, most of them staying as they are, and a closed mesh outside
// out; pairs the triangles at an edge of more than two so that each pair bounds the same material
// and gives every sheet its own vertices; fills small holes by triangles of the neighbouring
// element, about a new vertex in the middle where an edge across the hole is there already. Nothing
// else moves: positions stay as they are.
RepairReport repair(TriangleMesh& mesh, const RepairOptions& options = {});

// The table of `--repair`: a line a quantity, before and after, then what was done.
std::string to_text(const RepairReport& report);

}  // namespace diesink
