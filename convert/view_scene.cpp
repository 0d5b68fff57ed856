// SPDX-License-Identifier: Apache-2.0
#include "convert/view_scene.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "convert/lattice_map.h"
#include "convert/mesh_frame.h"
#include "convert/path_check.h"
#include "convert/path_input.h"
#include "core/parallel.h"
#include "core/tessellate/tessellate.h"
#include "formats/input_file.h"
#include "picture/sharp_edges.h"
#include "viewer/mesh_deviations.h"
#include "viewer/smooth_normals.h"

namespace diesink {
namespace {

constexpr double kSharpDegrees = 30;

// What the files hold.
struct Inputs {
  std::optional<CompoundSurface> part;
  std::optional<TriangleMesh> mesh;
  std::optional<ToolPath> path;
};

Error usage(std::string message) {
  return {ErrorCode::kUsage, std::move(message), {"diesink", 0, 0, -1}};
}

ExitStatus read_into(Inputs& inputs, const std::string& name, const ViewSources& sources,
                     const CommonOptions& common) {
  const Result<InputBytes> file = read_file(name, max_bytes_of(sources.in), common.threads);
  if (!file) return report(file.error());
  const auto once = [&](bool there, std::string_view what) {
    return there ? report(usage("'" + name + "' is a second " + std::string(what) +
                                "; expected one part program, one mesh and one path at most"))
                 : ExitStatus::kDone;
  };
  Diagnostics diagnostics;
  if (is_part_program(file->bytes(), name)) {
    if (const auto status = once(inputs.part.has_value(), "part program");
        status != ExitStatus::kDone)
      return status;
    const Loaded<PartProgram> program = load_part_program(file->bytes(), name, diagnostics);
    if (!program.value) return program.status;
    Loaded<CompoundSurface> surface = make_surface(*program.value);
    inputs.part = std::move(surface.value);
    return surface.status;
  }
  if (is_path(file->bytes(), name)) {
    if (const auto status = once(inputs.path.has_value(), "tool path"); status != ExitStatus::kDone)
      return status;
    Loaded<ToolPath> path = load_path(file->bytes(), name);
    inputs.path = std::move(path.value);
    return path.status;
  }
  if (const auto status = once(inputs.mesh.has_value(), "mesh"); status != ExitStatus::kDone)
    return status;
  Loaded<MeshFile> mesh = load_mesh(file->bytes(), name, sources.in, common, diagnostics);
  if (!mesh.value) return mesh.status;
  if (mesh.value->mesh.triangles.empty()) {
    return report(Error{ErrorCode::kInput, "a mesh without triangles", {name}});
  }
  inputs.mesh = std::move(mesh.value->mesh);
  return ExitStatus::kDone;
}

// Facts of an element by its name, from the tessellation and the palette.
std::vector<SceneElement> elements_of(const TriangleMesh& mesh, const Palette& palette,
                                      const TessellationReport* told) {
  std::vector<SceneElement> elements;
  const std::vector<std::uint32_t> entries = entries_of(mesh, palette);
  for (std::size_t k = 0; k < entries.size(); ++k) {
    const PaletteEntry& entry = palette[entries[k]];
    SceneElement element;
    element.name = mesh.elements.empty() ? "" : mesh.elements[k].name;
    element.color = entry.color;
    element.block = entry.block;
    if (told != nullptr) {
      const auto found =
          std::find_if(told->elements.begin(), told->elements.end(),
                       [&](const ElementReport& each) { return each.name == element.name; });
      if (found != told->elements.end()) {
        if (found->type != element.name) element.type = found->type;
        element.sign = found->sign;
        if (!entry.block) element.certified_deviation = found->max_deviation;
      }
    }
    elements.push_back(std::move(element));
  }
  return elements;
}

// The value that 98 of 100 stay below, so that a few far out do not wash out the rest.
double usual_largest(std::vector<float> deviations) {
  std::erase_if(deviations, [](float each) { return std::isnan(each); });
  if (deviations.empty()) return 0;
  for (float& each : deviations) each = std::abs(each);
  const auto at = static_cast<std::ptrdiff_t>(deviations.size() * 98 / 100);
  std::nth_element(deviations.begin(), deviations.begin() + at, deviations.end());
  return static_cast<double>(deviations[static_cast<std::size_t>(at)]);
}

// A solid's faces in the order of its statements, then its walls; base, sides and floor first and
// last.
void sort_elements(TriangleMesh& mesh, const Palette& palette) {
  const std::vector<std::uint32_t> entries = entries_of(mesh, palette);
  std::vector<std::uint32_t> order(mesh.elements.size()), place(mesh.elements.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return entries[a] < entries[b]; });
  std::vector<MeshElement> sorted;
  for (std::uint32_t k = 0; k < order.size(); ++k) {
    place[order[k]] = k;
    sorted.push_back(std::move(mesh.elements[order[k]]));
  }
  mesh.elements = std::move(sorted);
  for (std::uint32_t& each : mesh.triangle_element) each = place[each];
  for (MeshCurve& curve : mesh.curves) {
    for (std::uint32_t& each : curve.between) {
      if (each != MeshCurve::kNoElement) each = place[each];
    }
  }
}

// The tessellator's curves are the surface's; the sides and the floor have edges, too.
void add_block_edges(TriangleMesh& mesh, const std::vector<SceneElement>& elements) {
  TriangleMesh block;
  block.positions = mesh.positions;
  block.elements = mesh.elements;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!elements[mesh.triangle_element[t]].block) continue;
    block.triangles.push_back(mesh.triangles[t]);
    block.triangle_element.push_back(mesh.triangle_element[t]);
  }
  for (MeshCurve& edge : sharp_edges(block, kSharpDegrees)) {
    edge.kind = CurveKind::kEdge;
    mesh.curves.push_back(std::move(edge));
  }
}

ExitStatus show_part(Scene& scene, const CompoundSurface& part, const ViewSources& sources,
                     const CommonOptions& common) {
  Progress progress("tessellating", common.quiet);
  TessellationOptions how;
  how.tolerance = sources.tolerance.value_or(part.program().machining.tolerance);
  how.solid = true;
  how.threads = common.threads;
  how.progress = [&](double done) { progress.update(done); };
  Result<Tessellation> made = tessellate(part, how);
  if (!made && made.error().code == ErrorCode::kUnsupported) {
    // A surface without certified creases is shown by its grid array.
    how.scheme = MeshScheme::kGrid;
    how.creases = false;
    how.solid = false;
    made = tessellate(part, how);
  } else if (made) {
    scene.certified_deviation = made->report.certified_deviation;
  }
  if (!made) return report(made.error());
  if (made->mesh.triangles.empty()) {
    return report(Error{
        ErrorCode::kInput, "there is no surface over the domain", {part.program().file, 0, 0, -1}});
  }
  scene.mesh = std::move(made->mesh);
  progress.next("measuring", {static_cast<double>(scene.mesh.triangles.size()), "triangles"});
  const ProgressSpan span(progress.told(), 0, 1);
  const Palette palette = palette_of(part);
  sort_elements(scene.mesh, palette);
  scene.elements = elements_of(scene.mesh, palette, &made->report);
  add_block_edges(scene.mesh, scene.elements);
  scene.tolerance = how.tolerance;
  scene.deviations = mesh_deviations(scene.mesh, part, true, common.threads);
  scene.deviation_scale = how.tolerance;
  return ExitStatus::kDone;
}

ExitStatus show_mesh(Scene& scene, TriangleMesh mesh, const CompoundSurface* part,
                     const CommonOptions& common) {
  MeshFrame frame;
  if (mesh.up == UpAxis::kUnknown) frame.up_in = UpAxis::kZ;
  frame.up_out = UpAxis::kZ;
  if (part != nullptr) {
    if (mesh.unit == LengthUnit::kUnknown) frame.unit_in = scene.unit;
    frame.unit_out = scene.unit;
  }
  std::vector<std::string> warnings;
  if (Status done = change_frame(mesh, frame, warnings); !done) return report(done.error());
  const WorkAmount triangles{static_cast<double>(mesh.triangles.size()), "triangles"};
  Progress progress("finding edges", common.quiet, triangles);
  if (mesh.curves.empty()) mesh.curves = sharp_edges(mesh, kSharpDegrees);
  if (mesh.corner_normals.empty()) smooth_normals(mesh, kSharpDegrees);
  scene.elements = elements_of(mesh, palette_of(mesh), nullptr);
  if (part != nullptr) {
    progress.next("measuring", triangles);
    const ProgressSpan span(progress.told(), 0, 1);
    scene.tolerance = part->program().machining.tolerance;
    scene.deviations = mesh_deviations(mesh, *part, false, common.threads);
    scene.deviation_scale = std::max(scene.tolerance, usual_largest(scene.deviations));
    scene.coloring = "deviation";
  }
  scene.mesh = std::move(mesh);
  return ExitStatus::kDone;
}

// Colours for what the cutter leaves, over the lattice of `diesink verify`.
ExitStatus show_cut(Scene& scene, const CompoundSurface& part, const ViewSources& sources,
                    const CommonOptions& common) {
  constexpr std::size_t kMostPixels = 1000;  // a side
  CheckRequest request;
  request.cutter = sources.cutter;
  Result<VerifyOptions> how =
      verify_options(request, *scene.path, part.program(), sources.files[0]);
  if (!how) return report(how.error());
  Progress progress("verifying", common.quiet);
  how->threads = common.threads;
  how->progress = [&](double done) { progress.update(0.2 + 0.8 * done); };
  const Result<Tessellation> mesh = wide_mesh(part, *how);
  if (!mesh) return report(mesh.error());
  const Result<VerifyReport> found =
      verify_path(part, mesh->mesh, mesh->report.deviation_where_certified(), *scene.path, *how);
  if (!found) return report(found.error());
  const LatticeMap map = thinned(*found, how->intol, kMostPixels);
  CutMap cut;
  cut.columns = map.columns;
  cut.rows = map.rows;
  cut.limit = found->limit;
  cut.gouge_limit = how->intol;
  const Machining& m = part.program().machining;
  const auto place = [&](std::size_t axis, const std::array<double, 2>& range, std::size_t lines) {
    // A lattice point is the middle of its pixel.
    const double step =
        (range[1] - range[0]) / static_cast<double>(std::max<std::size_t>(2, lines) - 1);
    cut.corner[axis] = range[0] - step / 2;
    cut.pixel[axis] = step * static_cast<double>(map.every);
  };
  place(0, m.x_range, found->columns);
  place(1, m.y_range, found->rows);
  for (const std::size_t k : map.points) {
    const CutState state = found->state[k];
    cut.height.push_back(state == CutState::kCut     ? found->height[k]
                         : state == CutState::kUncut ? CutMap::kUncut
                                                     : CutMap::kNothing);
  }
  scene.cut = std::move(cut);
  scene.coloring = "cut";
  return ExitStatus::kDone;
}

}  // namespace

Loaded<Scene> load_scene(const ViewSources& sources, const CommonOptions& common) {
  Inputs inputs;
  for (const std::string& each : sources.files) {
    if (const ExitStatus status = read_into(inputs, each, sources, common);
        status != ExitStatus::kDone)
      return {std::nullopt, status};
  }
  if (sources.verify && !(inputs.part && inputs.path)) {
    return {std::nullopt, report(usage("--verify needs a part program and a tool path"))};
  }
  Scene scene;
  scene.maker = "diesink " DIESINK_VERSION;
  const CompoundSurface* part = inputs.part ? &*inputs.part : nullptr;
  scene.unit = part != nullptr ? part->program().unit
               : inputs.mesh   ? inputs.mesh->unit
                               : inputs.path->unit;
  scene.title = part != nullptr ? part->program().name
                : inputs.mesh   ? inputs.mesh->name
                                : inputs.path->name;
  ExitStatus status = ExitStatus::kDone;
  if (inputs.mesh) {
    status = show_mesh(scene, std::move(*inputs.mesh), part, common);
  } else if (part != nullptr) {
    status = show_part(scene, *part, sources, common);
  }
  if (status != ExitStatus::kDone) return {std::nullopt, status};
  if (part != nullptr) scene.cutter = part->program().machining.cutter;
  if (inputs.path) {
    if (scene.unit != LengthUnit::kUnknown) to_unit(*inputs.path, scene.unit);
    if (inputs.path->cutter) scene.cutter = inputs.path->cutter;
    scene.path = std::move(inputs.path);
  }
  if (sources.cutter) scene.cutter = Cutter{(*sources.cutter)[0], (*sources.cutter)[1]};
  if (sources.verify) {
    status = show_cut(scene, *part, sources, common);
    if (status != ExitStatus::kDone) return {std::nullopt, status};
  }
  return {std::move(scene), ExitStatus::kDone};
}

}  // namespace diesink
