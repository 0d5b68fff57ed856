// SPDX-License-Identifier: Apache-2.0
#include "core/machining/wide_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/ferguson.h"
#include "core/compound/compound_impl.h"

namespace diesink {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Extent {
  std::array<double, 2> x{kInfinity, -kInfinity}, y{kInfinity, -kInfinity};
  void add(double px, double py) {
    x = {std::fmin(x[0], px), std::fmax(x[1], px)};
    y = {std::fmin(y[0], py), std::fmax(y[1], py)};
  }
};

// Where the surface can be at all; the whole plan for bases without an end of their own.
Extent extent_of(const PartProgram& program) {
  Extent extent;
  for (const Solid& solid : program.solids) {
    for (const Vec3& corner : bounds_of(solid.body)) extent.add(corner.x(), corner.y());
  }
  if (const FergusonBase* grid = std::get_if<FergusonBase>(&program.base)) {
    const Result<FergusonSurface> base = FergusonSurface::make(*grid);
    if (base && base->affine()) {
      // A parallelogram in plan: its corners are grid points.
      const std::size_t m = static_cast<std::size_t>(grid->columns), n = grid->points.size();
      for (const std::size_t k : {std::size_t{0}, m - 1, n - m, n - 1}) {
        extent.add(grid->points[k].x(), grid->points[k].y());
      }
    } else if (base) {
      extent.add(base->plan_box().x0, base->plan_box().y0);
      extent.add(base->plan_box().x1, base->plan_box().y1);
    }
  } else if (std::holds_alternative<PlaneBase>(program.base)) {
    extent.add(-kInfinity, -kInfinity);
    extent.add(kInfinity, kInfinity);
  }
  return extent;
}

}  // namespace

Result<CompoundSurface> widened(const CompoundSurface& surface, double margin) {
  PartProgram program = surface.program();
  Extent extent = extent_of(program);
  const auto widen = [&](std::array<double, 2>& range, const std::array<double, 2>& most) {
    // A base that goes on by less than this millionth of the margin does so by the rounding of its
    // bounds: beyond its rim there is nothing, and the tessellator would look for it for ever.
    const double hair = 1e-6 * margin;
    const double low = std::fmax(range[0] - margin, most[0]);
    const double high = std::fmin(range[1] + margin, most[1]);
    if (low < range[0] - hair) range[0] = low;
    if (high > range[1] + hair) range[1] = high;
  };
  if (const ScannedSurface* scan = std::get_if<ScannedSurface>(&surface.impl().base)) {
    // The scan as it stands.
    const PlanBox& plan = scan->plan_box();
    extent.add(plan.x0, plan.y0);
    extent.add(plan.x1, plan.y1);
    MeshBase& base = std::get<MeshBase>(program.base);
    base.placement.clear();
    base.fill_size = 0;
    TriangleMesh mesh;
    mesh.positions = scan->positions();
    mesh.triangles = scan->triangles();
    widen(program.machining.x_range, extent.x);
    widen(program.machining.y_range, extent.y);
    return CompoundSurface::make(program, std::move(mesh));
  }
  widen(program.machining.x_range, extent.x);
  widen(program.machining.y_range, extent.y);
  return CompoundSurface::make(program);
}

}  // namespace diesink
