// SPDX-License-Identifier: Apache-2.0
#include "picture/preview.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "core/tessellate/tessellate.h"
#include "picture/annotate.h"
#include "picture/mesh_film.h"
#include "picture/occlusion.h"
#include "picture/plan_film.h"
#include "picture/sharp_edges.h"
#include "picture/surface_lines.h"

namespace diesink {
namespace {

using Box = std::array<Vec3, 2>;

constexpr double kSharpDegrees = 30;

std::size_t width_of(const PreviewOptions& options) {
  return static_cast<std::size_t>(options.size[0]);
}
std::size_t height_of(const PreviewOptions& options) {
  return static_cast<std::size_t>(options.size[1]);
}

Box box_of(const TriangleMesh& mesh) {
  Box box{mesh.positions[mesh.triangles[0][0]], mesh.positions[mesh.triangles[0][0]]};
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t v : triangle) {
      box[0] = box[0].cwiseMin(mesh.positions[v]);
      box[1] = box[1].cwiseMax(mesh.positions[v]);
    }
  }
  return box;
}

// Lowest and highest z of what the scale of heights colours: not the block under a part.
std::array<double, 2> heights_of(const TriangleMesh& mesh, const Palette& palette) {
  const std::vector<std::uint32_t> entries = entries_of(mesh, palette);
  std::array<double, 2> heights{HUGE_VAL, -HUGE_VAL};
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::size_t element = mesh.triangle_element.empty() ? 0 : mesh.triangle_element[t];
    if (palette[entries[element]].block) continue;
    for (const std::uint32_t v : mesh.triangles[t]) {
      heights[0] = std::min(heights[0], mesh.positions[v].z());
      heights[1] = std::max(heights[1], mesh.positions[v].z());
    }
  }
  return heights;
}

std::string unit_text(LengthUnit unit) {
  return unit == LengthUnit::kUnknown ? "" : std::string(name_of(unit));
}

void set_scale(Paint& paint, const std::array<double, 2>& heights, double tolerance) {
  paint.low = 0;
  switch (paint.coloring) {
    case Coloring::kHeight:
      paint.low = heights[0];
      paint.high = heights[1];
      return;
    case Coloring::kDeviation:
      paint.low = -tolerance;
      paint.high = tolerance;
      return;
    case Coloring::kSlope:
    case Coloring::kElement:
      paint.high = 90;
      return;
  }
}

// Everything over the film: shadows of hollows, lines, lettering.
Picture develop(Film& film, const TriangleMesh& mesh, std::span<const MeshCurve> curves,
                const Camera& camera, const Paint& paint, const Layout& layout,
                const PreviewOptions& options) {
  const double reach = 0.035 * static_cast<double>(std::min(film.width, film.height));
  {
    const ProgressSpan span(options.progress, 0.7, 0.9);
    occlude(film, camera.scale, reach, options.threads);
  }
  Canvas canvas(film);
  draw_curves(mesh, curves, camera, film, canvas);
  if (!options.bare) annotate(film, camera, paint, layout, unit_text(mesh.unit), canvas);
  return {film.width, film.height, canvas.pixels()};
}

// The domain in plan and the heights of the solids over it: what the tessellation's size follows
// from before there is one.
double pixel_length(const CompoundSurface& surface, const Layout& layout) {
  const Machining& m = surface.program().machining;
  const Vec3 low(m.x_range[0], m.y_range[0], 0), high(m.x_range[1], m.y_range[1], 0);
  return 1 / make_camera(View::kPlan, {low, high}, layout.surface).scale;
}

}  // namespace

Result<Picture> preview(const CompoundSurface& surface, const PreviewOptions& options) {
  const Palette palette = palette_of(surface);
  Paint paint{options.coloring, &palette, &surface};
  const double tolerance = surface.program().machining.tolerance;
  set_scale(paint, {0, 0}, tolerance);
  Layout layout = make_layout(width_of(options), height_of(options), paint,
                              unit_text(surface.program().unit), options.bare);
  const bool deviation = options.coloring == Coloring::kDeviation;
  const bool plan = options.view == View::kPlan;
  TessellationOptions how;
  how.threads = options.threads;
  how.progress = [&](double part) {
    if (options.progress) options.progress(0.2 * part);
  };
  how.tolerance = deviation ? tolerance : 0.2 * pixel_length(surface, layout);
  how.solid = !plan && !deviation;
  Result<Tessellation> die = tessellate(surface, how);
  if (!die && die.error().code == ErrorCode::kUnsupported) {
    // A surface without certified creases is seen by its grid array.
    how.scheme = MeshScheme::kGrid;
    how.creases = false;
    how.solid = false;
    die = tessellate(surface, how);
  }
  if (!die) return die.error();
  const TriangleMesh& mesh = die->mesh;
  if (mesh.triangles.empty()) {
    return Error{ErrorCode::kInput,
                 "there is no surface over the domain",
                 {surface.program().file, 0, 0, -1}};
  }
  const Box box = box_of(mesh);
  set_scale(paint, heights_of(mesh, palette), tolerance);
  layout =
      make_layout(width_of(options), height_of(options), paint, unit_text(mesh.unit), options.bare);
  const Camera camera = make_camera(options.view, box, layout.surface);
  Film film(width_of(options), height_of(options));
  const ProgressSpan span(options.progress, 0.2, 0.7);
  if (plan && !deviation) {
    film_plan(surface, camera, paint, options.threads, film);
  } else {
    film_mesh(mesh, camera, paint, options.threads, film);
  }
  return develop(film, mesh, mesh.curves, camera, paint, layout, options);
}

Result<Picture> preview(const TriangleMesh& given, const PreviewOptions& options) {
  if (options.coloring == Coloring::kDeviation) {
    return Error{
        ErrorCode::kUsage,
        "deviations are those of a part program's mesh from its surface; a mesh alone has none",
        {}};
  }
  if (given.triangles.empty()) return Error{ErrorCode::kInput, "a mesh without triangles", {}};
  TriangleMesh turned;
  if (given.up == UpAxis::kY) {
    turned = given;
    const auto to_z_up = [](Vec3& p) { p = Vec3(p.x(), -p.z(), p.y()); };
    std::for_each(turned.positions.begin(), turned.positions.end(), to_z_up);
    std::for_each(turned.normals.begin(), turned.normals.end(), to_z_up);
  }
  const TriangleMesh& mesh = given.up == UpAxis::kY ? turned : given;
  const Palette palette = palette_of(mesh);
  Paint paint{options.coloring, &palette, nullptr};
  const Box box = box_of(mesh);
  set_scale(paint, heights_of(mesh, palette), 0);
  const Layout layout =
      make_layout(width_of(options), height_of(options), paint, unit_text(mesh.unit), options.bare);
  const Camera camera = make_camera(options.view, box, layout.surface);
  Film film(width_of(options), height_of(options));
  const ProgressSpan span(options.progress, 0, 0.7);
  film_mesh(mesh, camera, paint, options.threads, film);
  const std::vector<MeshCurve> found =
      mesh.curves.empty() ? sharp_edges(mesh, kSharpDegrees) : std::vector<MeshCurve>{};
  return develop(film, mesh, mesh.curves.empty() ? found : mesh.curves, camera, paint, layout,
                 options);
}

}  // namespace diesink
