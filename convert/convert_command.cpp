// `diesink convert`: from mesh file to mesh file.
// SPDX-License-Identifier: Apache-2.0
#include <CLI/App.hpp>
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "convert/arguments.h"
#include "convert/commands.h"
#include "convert/mesh_frame.h"
#include "convert/mesh_input.h"
#include "convert/mesh_output.h"
#include "core/counted.h"
#include "core/mesh_tools/repair.h"
#include "core/mesh_tools/weld.h"
#include "core/parallel.h"
#include "formats/json_writer.h"

namespace diesink {
namespace {

struct Options {
  std::string input, output;
  std::string stdout_format = "obj";
  MeshFrame frame;
  std::optional<double> tolerance, weld, max_hole;
  bool repair = false;
  MeshInputOptions in;
  MeshOutputOptions out;
};

constexpr std::array<Choice, 4> kUnits{{{"mm", static_cast<int>(LengthUnit::kMillimetre)},
                                        {"cm", static_cast<int>(LengthUnit::kCentimetre)},
                                        {"m", static_cast<int>(LengthUnit::kMetre)},
                                        {"inch", static_cast<int>(LengthUnit::kInch)}}};
constexpr std::array<Choice, 2> kUpAxes{
    {{"y", static_cast<int>(UpAxis::kY)}, {"z", static_cast<int>(UpAxis::kZ)}}};

// What was changed because --weld or --repair asked for it.
struct Mended {
  std::optional<WeldReport> weld;
  std::optional<RepairReport> repair;
};

Mended mend(TriangleMesh& mesh, const Options& options) {
  Mended mended;
  if (options.repair) {
    RepairOptions how;
    how.weld = options.weld.value_or(how.weld);
    how.max_hole = options.max_hole.value_or(how.max_hole);
    mended.repair = repair(mesh, how);
  } else if (options.weld) {
    mended.weld = weld(mesh, *options.weld);
  }
  return mended;
}

std::string mended_text(const Mended& mended) {
  if (mended.repair) return to_text(*mended.repair);
  if (!mended.weld) return {};
  return "welded: " + counted(mended.weld->merged_vertices, "vertex|vertices| merged, ") +
         counted(mended.weld->collapsed_triangles, "triangle|triangles| collapsed\n");
}

void write_mended(JsonWriter& json, const Mended& mended) {
  if (mended.weld) {
    json.key("weld")
        .begin_object()
        .field("merged_vertices", mended.weld->merged_vertices)
        .field("collapsed_triangles", mended.weld->collapsed_triangles)
        .end_object();
  }
  if (!mended.repair) return;
  const RepairReport& done = *mended.repair;
  json.key("repair")
      .begin_object()
      .field("merged_vertices", done.merged_vertices)
      .field("removed_degenerate", done.removed_degenerate)
      .field("removed_duplicates", done.removed_duplicates)
      .field("flipped", done.flipped)
      .field("split_edges", done.split_edges)
      .field("split_vertices", done.split_vertices)
      .field("filled_holes", done.filled_holes)
      .field("added_triangles", done.added_triangles)
      .field("unorientable", done.unorientable)
      .field("watertight_before", done.before.watertight)
      .field("watertight_after", done.after.watertight)
      .end_object();
}

std::string as_json(const MeshFile& in, const MeshTarget& target, const WrittenMesh& written,
                    const Mended& mended, const Diagnostics& read, const Diagnostics& told) {
  JsonWriter json;
  json.begin_object()
      .field("from", in.format->id)
      .field("to", target.format->id)
      .field("vertices", in.mesh.positions.size())
      .field("triangles", in.mesh.triangles.size())
      .field("units", name_of(in.mesh.unit))
      .field("deviation", written.deviation);
  json.key("warnings").begin_array();
  for (const Diagnostics* stage : {&read, &told}) {
    for (const Diagnostic& each : stage->all()) json.value(to_text(each));
  }
  json.end_array();
  write_mended(json, mended);
  json.end_object();
  return json.text() + "\n";
}

ExitStatus convert(const Options& options, const CommonOptions& common, MeshFile& in,
                   const MeshTarget& target, const Diagnostics& read) {
  const WorkAmount triangles{static_cast<double>(in.mesh.triangles.size()), "triangles"};
  Progress progress("mending", common.quiet, triangles);
  const Mended mended = [&] {
    const ProgressSpan span(progress.told(), 0, 1);
    return mend(in.mesh, options);
  }();
  progress.next("writing " + target.path, triangles);
  Diagnostics told;
  const auto warn = [&](const std::string& file, const std::vector<std::string>& messages) {
    for (const std::string& each : messages) told.warning(each, {file, 0, 0, -1});
  };
  std::vector<std::string> doubts;
  if (Status done = change_frame(in.mesh, options.frame, doubts); !done) {
    return report(Error{done.error().code, done.error().message, {options.input, 0, 0, -1}});
  }
  warn(options.input, doubts);
  warn(options.input, assumed_in(target, in.mesh));
  warn(target.path, lost_in(target, in.mesh, options.out));
  OutputFiles files;
  WriteOptions write;
  write.lines = true;
  write.tolerance = 2 * options.tolerance.value_or(0);  // writers keep half of it
  const Result<WrittenMesh> written = [&] {
    const ProgressSpan span(progress.told(), 0, 1);
    return write_mesh(files, target, in.mesh, options.out, write);
  }();
  if (!written) return report(written.error());
  warn(target.path, written->notes);
  report(told);
  if (Status done = files.commit(); !done) return report(done.error());
  if (common.json) return print(as_json(in, target, *written, mended, read, told));
  return common.quiet || target.path == "-" ? ExitStatus::kDone : print(mended_text(mended));
}

ExitStatus run(const Options& options, const CommonOptions& common) {
  Result<std::vector<MeshTarget>> targets =
      mesh_targets({options.output}, options.stdout_format, options.out);
  if (!targets) return report(targets.error());
  if (options.output == "-" && common.json)
    return report_usage("OUT - and --json both want stdout");
  Diagnostics diagnostics;
  Loaded<MeshFile> in = load_mesh(options.input, options.in, common, diagnostics);
  if (!in.value) return in.status;
  return convert(options, common, *in.value, targets->front(), diagnostics);
}

Run setup(CLI::App& app) {
  const auto options = std::make_shared<Options>();
  Options& to = *options;
  app.add_option("IN", to.input, "mesh to read, told by its content; - is stdin")
      ->required()
      ->type_name("");
  app.add_option("OUT", to.output, "mesh to write, told by its ending; - is stdout")
      ->required()
      ->type_name("");
  add_stdout_format(app, to.stdout_format);
  add_choice(app, "--units-in", to.frame.unit_in, kUnits,
             "what the file's lengths are in, whatever it says");
  add_choice(app, "--units-out", to.frame.unit_out, kUnits, "what they shall be in");
  add_choice(app, "--up-in", to.frame.up_in, kUpAxes, "the file's up axis, whatever it says");
  add_choice(app, "--up-out", to.frame.up_out, kUpAxes, "what the up axis shall be");
  add_number(app, "--tolerance", to.tolerance,
             "for --draco: how far it may move a vertex (default 5e-6 of the extent)", kPositive);
  add_number(app, "--weld", to.weld, "vertices this close become one, in the file's lengths",
             kNotNegative);
  add_flag_with_number(app, "--repair", to.repair, to.max_hole,
                       "orient, split what is not manifold, fill holes up to =SIZE (default: a "
                       "twentieth of the mesh)",
                       kNotNegative);
  add_mesh_output_options(app, to.out);
  add_mesh_input_options(app, to.in);
  return [options](const CommonOptions& common) { return run(*options, common); };
}

}  // namespace

const Command kConvertCommand{"convert", "mesh to mesh: formats, units, up axis, repair",
                              "diesink convert out/fig6.stl out/fig6.glb --units-in mm --up-in z",
                              true, setup};

}  // namespace diesink
