// The deepest gouge of a path into a mesh: every move against every triangle it may reach.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/machining/sweep_depth.h"
#include "core/mesh.h"

namespace diesink {

struct Gouge {
  double depth = 0, bound = 0;  // the deepest lies in [depth, bound]
  SweepMove move;
  std::uint32_t triangle = 0;
  Vec3 at = Vec3::Zero();  // on the triangle
};

// Triangles of a mesh in the cells of a plan grid, with the highest point of each cell.
class GougeSearch {
 public:
  // Needs: `mesh` outlives it.
  explicit GougeSearch(const TriangleMesh& mesh, const CutterShape& cutter);

  // Takes the next moves of a path. Pieces of any size give the same depth.
  void add(std::span<const SweepMove> moves, int threads);
  // The deepest of all moves so far.
  [[nodiscard]] Gouge deepest() const;

  // Whether the cutter, standing with its tip there, meets nothing deeper than `depth`.
  // May be called from several threads.
  [[nodiscard]] bool stands_free(const Vec3& tip, double depth) const;

 private:
  // Marks of triangles already examined for the move at hand.
  struct Scratch {
    std::vector<std::uint32_t> seen;
    std::uint32_t mark = 0;
  };
  // Marks the items [begin, begin + count) whose part in their cell the cutter may hold deeper than
  // `limit` is over the tip, which stays in the box from `low` to `high`.
  void mark_near(std::uint32_t begin, std::uint32_t count, const Vec2& low, const Vec2& high,
                 double limit, std::uint8_t* near) const;
  // Calls visit(triangle) for the triangles that may reach deeper than `depth` into the move, some
  // of them more than once, until it returns false; depth may grow meanwhile.
  template <class Visit>
  void each_near(const SweepMove& move, const double& depth, const Visit& visit) const;
  [[nodiscard]] double ceiling_over(const SweepMove& move) const;
  [[nodiscard]] std::array<Vec3, 3> corners(std::uint32_t triangle) const;
  [[nodiscard]] Vec3 deepest_point(const SweepMove& move, std::uint32_t triangle) const;
  void search(const SweepMove& move, Scratch& scratch, Gouge& worst) const;

  const TriangleMesh* mesh_;
  CutterShape cutter_;
  double x0_ = 0, y0_ = 0, cell_ = 1, ceiling_ = 0;
  int nx_ = 1, ny_ = 1;
  std::vector<std::uint32_t> start_, items_;
  std::vector<float> tops_;  // of the cells, rounded up
  // Of each item the part of its triangle's box that lies in its cell, and the triangle's top;
  // rounded outward.
  std::vector<float> low_x_, high_x_, low_y_, high_y_, high_z_;
  Gouge worst_;
  std::vector<Scratch> scratch_;  // one a thread
};

}  // namespace diesink
