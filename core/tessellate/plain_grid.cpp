// Triangles straight from the grid array (paper, Fig. 8, before its edges are detected).
// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/plain_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <vector>

#include "core/grid/grid_array.h"
#include "core/tessellate/assemble.h"
#include "core/tessellate/mesh_report.h"

namespace diesink {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

// The program's lines inside [low, high], and both ends.
std::vector<double> lines_within(const std::array<double, 2>& range, double interval, double low,
                                 double high) {
  std::vector<double> lines{low};
  for (const double line : grid_lines(range[0], range[1], interval)) {
    if (line > low && line < high) lines.push_back(line);
  }
  lines.push_back(high);
  return lines;
}

class PlainGrid {
 public:
  PlainGrid(const CompoundSurface& surface, const GridArray& grid)
      : surface_(surface), grid_(grid), vertex_of_(grid.size(), MeshCurve::kNoElement) {}

  Tessellation make() {
    for (std::size_t j = 0; j + 1 < grid_.rows(); ++j) {
      for (std::size_t i = 0; i + 1 < grid_.columns(); ++i) add_cell(i, j);
    }
    if (!made_.mesh.triangles.empty()) complete();
    return std::move(made_);
  }

 private:
  // Corners anticlockwise from the lower left; a hole among them drops out.
  void add_cell(std::size_t i, std::size_t j) {
    const std::size_t at = j * grid_.columns() + i;
    std::array<std::size_t, 4> corners{at, at + 1, at + grid_.columns() + 1, at + grid_.columns()};
    const auto end = std::remove_if(corners.begin(), corners.end(), [&](std::size_t corner) {
      return grid_.label()[corner] == kNoLabel;
    });
    const std::ptrdiff_t count = end - corners.begin();
    if (count >= 3) add_triangle({corners[0], corners[1], corners[2]});
    if (count == 4) add_triangle({corners[0], corners[2], corners[3]});
  }

  void add_triangle(const std::array<std::size_t, 3>& corners) {
    TriangleMesh& mesh = made_.mesh;
    const std::array<std::uint32_t, 3> vertices{vertex(corners[0]), vertex(corners[1]),
                                                vertex(corners[2])};
    mesh.triangles.push_back(vertices);
    mesh.corner_normals.push_back(vertices);
    mesh.triangle_element.push_back(element(grid_.label()[corners[0]]));
  }

  std::uint32_t vertex(std::size_t corner) {
    TriangleMesh& mesh = made_.mesh;
    std::uint32_t& index = vertex_of_[corner];
    if (index == MeshCurve::kNoElement) {
      index = static_cast<std::uint32_t>(mesh.positions.size());
      mesh.positions.emplace_back(grid_.x()[corner % grid_.columns()],
                                  grid_.y()[corner / grid_.columns()], grid_.z()[corner]);
      mesh.normals.emplace_back(grid_.nx()[corner], grid_.ny()[corner], grid_.nz()[corner]);
    }
    return index;
  }

  std::uint32_t element(Label label) {
    const auto [known, is_new] =
        element_of_.try_emplace(label, static_cast<std::uint32_t>(element_of_.size()));
    if (is_new) add_element(label);
    return known->second;
  }

  void add_element(Label label) {
    const PartProgram& program = surface_.program();
    const int number = surface_.surface_of_row(row_of(label));
    made_.mesh.elements.push_back(
        {surface_.element_name(label),
         number == 0 ? "B" : program.solids[static_cast<std::size_t>(number - 1)].id,
         std::nullopt});
  }

  void complete() {
    TriangleMesh& mesh = made_.mesh;
    TessellationReport& report = made_.report;
    mesh.name = surface_.program().name;
    mesh.unit = surface_.program().unit;
    mesh.up = UpAxis::kZ;
    report.domain = {grid_.x().front(), grid_.x().back(), grid_.y().front(), grid_.y().back()};
    double lowest = std::numeric_limits<double>::infinity();
    for (const Vec3& each : mesh.positions) lowest = std::fmin(lowest, each.z());
    fill_report(surface_, made_, lowest, report);
    for (const Triangle& each : mesh.triangles) {
      const Vec3 across = mesh.positions[each[1]] - mesh.positions[each[0]];
      const Vec3 along = mesh.positions[each[2]] - mesh.positions[each[0]];
      report.uncertified_area += (across.x() * along.y() - across.y() * along.x()) / 2;
    }
  }

  const CompoundSurface& surface_;
  const GridArray& grid_;
  std::vector<std::uint32_t> vertex_of_;  // of each grid point that a triangle uses
  std::map<Label, std::uint32_t> element_of_;
  Tessellation made_;
};

}  // namespace

Result<Tessellation> mesh_plain_grid(const CompoundSurface& surface, const PlanBox& box,
                                     const TessellationOptions& options) {
  if (options.solid) {
    return Error{ErrorCode::kUsage, "a grid without creases cannot be closed into a solid", {}};
  }
  const Machining& machining = surface.program().machining;
  Result<GridArray> grid = evaluate_grid(
      surface, lines_within(machining.x_range, machining.x_interval, box.x0, box.x1),
      lines_within(machining.y_range, machining.y_interval, box.y0, box.y1), options.threads);
  if (!grid) return grid.error();
  Tessellation made = PlainGrid(surface, *grid).make();
  if (made.mesh.triangles.empty()) {
    if (options.tiles != std::array{1, 1}) return empty_tile(box);
    return Error{
        ErrorCode::kInput, "there is no surface in the domain", {surface.program().file, 0, 0, -1}};
  }
  made.report.tolerance = options.tolerance > 0 ? options.tolerance : machining.tolerance;
  return made;
}

}  // namespace diesink
