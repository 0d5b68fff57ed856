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
#include "formats/json_writer.h"

namespace diesink {
namespace {

struct Options {
  std::string input, output;
  std::string stdout_format = "obj";
  MeshFrame frame;
  std::optional<double> tolerance;
  MeshInputOptions in;
  MeshOutputOptions out;
};

constexpr std::array<Choice, 4> kUnits{{{"mm", static_cast<int>(LengthUnit::kMillimetre)},
                                        {"cm", static_cast<int>(LengthUnit::kCentimetre)},
                                        {"m", static_cast<int>(LengthUnit::kMetre)},
                                        {"inch", static_cast<int>(LengthUnit::kInch)}}};
constexpr std::array<Choice, 2> kUpAxes{
    {{"y", static_cast<int>(UpAxis::kY)}, {"z", static_cast<int>(UpAxis::kZ)}}};

std::string as_json(const MeshFile& in, const MeshTarget& target, const WrittenMesh& written,
                    const Diagnostics& read, const Diagnostics& told) {
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
  json.end_array().end_object();
  return json.text() + "\n";
}

ExitStatus convert(const Options& options, const CommonOptions& common, MeshFile& in,
                   const MeshTarget& target, const Diagnostics& read) {
  Diagnostics told;
  const auto warn = [&](const std::string& file, const std::vector<std::string>& messages) {
    for (const std::string& each : messages) told.warning(each, {file, 0, 0, -1});
  };
  std::vector<std::string> doubts;
  if (Status done = change_frame(in.mesh, options.frame, doubts); !done) {
    return report(Error{done.error().code, done.error().message, {options.input, 0, 0, -1}});
  }
  warn(options.input, doubts);
  warn(target.path, lost_in(*target.format, in.mesh));
  OutputFiles files;
  WriteOptions write;
  write.lines = true;
  write.tolerance = options.tolerance.value_or(0);
  const Result<WrittenMesh> written = write_mesh(files, target, in.mesh, options.out, write);
  if (!written) return report(written.error());
  warn(target.path, written->notes);
  report(told);
  if (Status done = files.commit(); !done) return report(done.error());
  return common.json ? print(as_json(in, target, *written, read, told)) : ExitStatus::kDone;
}

ExitStatus run(const Options& options, const CommonOptions& common) {
  Result<std::vector<MeshTarget>> targets =
      mesh_targets({options.output}, options.stdout_format, options.out);
  if (!targets) return report(targets.error());
  if (options.output == "-" && common.json)
    return report_usage("OUT - and --json both want stdout");
  Diagnostics diagnostics;
  Loaded<MeshFile> in = load_mesh(options.input, options.in, common.threads, diagnostics);
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
             "for --draco: largest distance it may move a vertex, twice over", kPositive);
  add_mesh_output_options(app, to.out);
  add_mesh_input_options(app, to.in);
  return [options](const CommonOptions& common) { return run(*options, common); };
}

}  // namespace

const Command kConvertCommand{"convert", "mesh to mesh: formats, units, up axis",
                              "diesink convert out/fig6.stl out/fig6.glb --units-in mm --up-in z",
                              true, setup};

}  // namespace diesink
