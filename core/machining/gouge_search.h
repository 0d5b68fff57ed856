// The deepest gouge of a path into a mesh: every move against every triangle it may reach.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/machining/sweep_depth.h"
#include "core/mesh.h"

namespace diesink {

struct Gouge {
  double depth = 0, bound = 0;  // the deepest lies in [depth, bound]
  std::size_t move = 0;
  std::uint32_t triangle = 0;
  Vec3 at = Vec3::Zero();  // on the triangle
};

// Triangles of a mesh in the cells of a plan grid, with the highest point of each cell.
class GougeSearch {
 public:
  // Needs: `mesh` outlives it.
  explicit GougeSearch(const TriangleMesh& mesh, const CutterShape& cutter);

  // The deepest of all moves; the first of equals.
  [[nodiscard]] Gouge deepest(const std::vector<SweepMove>& moves, int threads) const;

 private:
  struct Scratch;
  [[nodiscard]] Vec3 deepest_point(const SweepMove& move, std::uint32_t triangle) const;
  void search(const SweepMove& move, std::size_t index, Scratch& scratch, Gouge& worst) const;

  const TriangleMesh* mesh_;
  CutterShape cutter_;
  double x0_ = 0, y0_ = 0, cell_ = 1, ceiling_ = 0;
  int nx_ = 1, ny_ = 1;
  std::vector<std::uint32_t> start_, items_;
  std::vector<float> tops_;  // of the cells, rounded up
};

}  // namespace diesink
