// `diesink info`: what a part program or a mesh file holds.
// SPDX-License-Identifier: Apache-2.0
#include <CLI/App.hpp>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "convert/commands.h"
#include "convert/input.h"
#include "convert/mesh_info.h"
#include "convert/mesh_input.h"
#include "convert/program_info.h"
#include "core/compound/compound_impl.h"
#include "core/parallel.h"

namespace diesink {
namespace {

struct Options {
  std::string file;
  MeshInputOptions in;
  bool crossings = false;
};

ExitStatus tell_program(std::span<const std::byte> bytes, const std::string& path,
                        const CommonOptions& common) {
  Diagnostics diagnostics;
  const Loaded<PartProgram> program = load_part_program(bytes, path, diagnostics);
  if (!program.value) return program.status;
  if (std::holds_alternative<MeshBase>(program.value->base)) {
    // Domain and grid may be the scan's.
    const Loaded<CompoundSurface> surface = make_surface(*program.value, &diagnostics);
    if (!surface.value) return surface.status;
    const PartProgram& resolved = surface.value->program();
    const std::optional<ScanFigures> scan = scan_figures(*surface.value, common.threads);
    return print(common.json ? program_info_json(resolved, diagnostics, &*scan)
                             : program_info(resolved, &*scan));
  }
  return print(common.json ? program_info_json(*program.value, diagnostics)
                           : program_info(*program.value));
}

ExitStatus tell_mesh(std::span<const std::byte> bytes, const Options& options,
                     const CommonOptions& common) {
  Diagnostics diagnostics;
  const Loaded<MeshFile> file = load_mesh(bytes, options.file, options.in, common, diagnostics);
  if (!file.value) return file.status;
  const MeshTopology topology = [&] {
    const Progress progress("counting", common.quiet,
                            {static_cast<double>(file.value->mesh.triangles.size()), "triangles"});
    const ProgressSpan span(progress.told(), 0, 1);
    return topology_of(file.value->mesh);
  }();
  std::optional<MeshCrossings> crossings;
  if (options.crossings) {
    const Progress progress("looking for crossings", common.quiet,
                            {static_cast<double>(file.value->mesh.triangles.size()), "triangles"});
    const ProgressSpan span(progress.told(), 0, 1);
    crossings = find_crossings(file.value->mesh, common.threads);
  }
  const MeshCrossings* const found = crossings ? &*crossings : nullptr;
  return print(common.json ? mesh_info_json(*file.value, topology, diagnostics, found)
                           : mesh_info(*file.value, topology, found));
}

ExitStatus run(const Options& options, const CommonOptions& common) {
  const Result<InputBytes> file = read_file(options.file, max_bytes_of(options.in), common.threads);
  if (!file) return report(file.error());
  return is_part_program(file->bytes(), options.file)
             ? tell_program(file->bytes(), options.file, common)
             : tell_mesh(file->bytes(), options, common);
}

Run setup(CLI::App& app) {
  const auto options = std::make_shared<Options>();
  app.add_option("FILE", options->file, "part program or mesh, told by its content; - is stdin")
      ->required()
      ->type_name("");
  app.add_flag("--crossings", options->crossings,
               "of a mesh, also tell the triangles that cross one another");
  add_mesh_input_options(app, options->in);
  return [options](const CommonOptions& common) { return run(*options, common); };
}

}  // namespace

const Command kInfoCommand{"info", "what a part program or a mesh holds",
                           "diesink info fixtures/parts/fig6.part", true, setup};

}  // namespace diesink
