// What stays over the part, at the points of a lattice and in the cells between them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/compound/compound_surface.h"
#include "core/machining/gouge_search.h"
#include "core/machining/height_pyramid.h"
#include "core/machining/swept_heights.h"
#include "core/machining/verify.h"
#include "core/mesh.h"

namespace diesink {

// Heights (NaN in holes) and normals of the surface over a lattice.
struct LatticeHeights {
  std::vector<double> z;
  std::vector<float> nx, ny, nz;
};
LatticeHeights heights_over(const CompoundSurface& surface, const PlanLattice& lattice,
                            int threads);

// For each cell how far the part lies, somewhere in it, below the straight surface between its four
// points, at most; infinity where a wall of more than `wall` runs through it or a point is in a
// hole. Bound: certain for the true surface where the mesh lies within `deviation` of it.
std::vector<float> cell_dips(const TriangleMesh& mesh, double deviation, const PlanLattice& lattice,
                             const std::vector<double>& z, double wall, int threads);

// What one row of the lattice adds to the report.
struct RowFindings {
  double excess = -1, bound = -1;
  Vec3 excess_at = Vec3::Zero();
  double uncut = 0,
         unreachable = 0;  // in cells: a point on the domain's side stands for half a one
  std::size_t cells = 0, proven_cells = 0;
  std::vector<float> cusps;
  // Columns of points that the cutter cannot stand on, but could clear better from beside: how far
  // the part is below tells nothing there.
  std::vector<std::size_t> beside;
  // Cells that a bound of the whole cell leaves above the limit, with that bound. `over`: more than
  // the limit stays at a corner.
  struct Open {
    std::size_t cell = 0;
    double bound = 0;
    bool over = false;
  };
  std::vector<Open> open;
};

class LatticeCheck {
 public:
  // `mesh` tells where a cutter stands free; it lies at most `deviation` from the surface.
  // Needs: all outlive it.
  LatticeCheck(const CompoundSurface& surface, const CutterShape& cutter,
               const PlanLattice& lattice, const LatticeHeights& heights, const GougeSearch& mesh,
               double deviation, const VerifyOptions& options);

  // The points of row j.
  RowFindings row(std::size_t j, const SweptHeights& swept, float* height, CutState* state) const;

  // What the cells of row j prove, once its points and those of the `next` row are known; adds to
  // what `row` found.
  void cells(std::size_t j, const SweptHeights& swept, const std::vector<float>& dips,
             const VerifyReport& points, RowFindings& out, const RowFindings& next) const;

  [[nodiscard]] double limit() const { return limit_; }

 private:
  // Equation (6) puts the cutter on the point; it must clear everything around and stand in the
  // domain.
  [[nodiscard]] bool reachable(std::size_t i, std::size_t j, double z, const Vec3& n,
                               double stays) const;
  // How deep a cutter that stands free, in the domain, may hold the point, from below and to a
  // sixty-fourth: 0 where not deeper than the limit. Beside walls, where no contact is at the point
  // itself.
  [[nodiscard]] double depth_of_free_cutter(std::size_t i, std::size_t j, double z) const;
  // Whether what is left falls off steeply beside the point.
  [[nodiscard]] bool steep_beside(const std::vector<double>& left, std::size_t i,
                                  std::size_t j) const;
  [[nodiscard]] bool in_domain(const Vec2& p) const;
  // Distance of a point above the surface to it, or a little more.
  [[nodiscard]] double distance(const Vec3& p, double above) const;

  const CompoundSurface* surface_;
  CutterShape cutter_;
  PlanLattice lattice_;
  double limit_, slack_;
  const LatticeHeights* z_;
  const GougeSearch* mesh_;
  // So deep a cutter still counts as standing free: on the true surface it is in the mesh by up to
  // the deviation, and a touch is quicker told with some room.
  double least_touch_, touch_;
  HeightPyramid pyramid_;  // coarse and quick, before the mesh is asked
};

}  // namespace diesink
