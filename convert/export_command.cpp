// `diesink export`: from a part program to meshes in files.
// SPDX-License-Identifier: Apache-2.0
#include <CLI/App.hpp>
#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>

#include "convert/arguments.h"
#include "convert/commands.h"
#include "convert/export_run.h"
#include "convert/input.h"
#include "core/parallel.h"

namespace diesink {
namespace {

struct Options : ExportOptions {
  std::string part;
  std::vector<std::string> outputs, more_outputs;
  std::string stdout_format = "obj";
};

constexpr std::array<Choice, 2> kSchemes{{{"adaptive", static_cast<int>(MeshScheme::kAdaptive)},
                                          {"grid", static_cast<int>(MeshScheme::kGrid)}}};
constexpr std::array<Choice, 3> kGroups{{{"element", static_cast<int>(MeshGroups::kElement)},
                                         {"solid", static_cast<int>(MeshGroups::kSolid)},
                                         {"none", static_cast<int>(MeshGroups::kNone)}}};

Error usage(std::string message) {
  return {ErrorCode::kUsage, std::move(message), {"diesink", 0, 0, -1}};
}

Result<std::vector<MeshTarget>> targets_of(Options& options, const CommonOptions& common) {
  options.outputs.insert(options.outputs.end(), options.more_outputs.begin(),
                         options.more_outputs.end());
  const bool to_stdout = std::count(options.outputs.begin(), options.outputs.end(), "-") > 0;
  if (to_stdout && common.json) return usage("-o - and --json both want stdout");
  if (to_stdout && options.tiles != std::array{1, 1}) return usage("--tiles needs files, not -o -");
  if (!options.creases && (options.scheme != MeshScheme::kGrid || options.solid)) {
    return usage("--no-creases needs --mesh grid, and no --solid");
  }
  return mesh_targets(options.outputs, options.stdout_format, options.mesh);
}

void say_not_kept(const std::string& part, const TessellationReport& report) {
  char line[256];
  std::snprintf(
      line, sizeof line,
      "the tolerance %.6g is not certified: deviation up to %.6g, uncertified plan area %.6g",
      report.tolerance, report.certified_deviation, report.uncertified_area);
  report_warning(part, line);
  for (const MeshDoubt& doubt : report.doubts) {
    std::snprintf(line, sizeof line, "at (%.6g, %.6g, %.6g)%s%s: %s", doubt.place.x(),
                  doubt.place.y(), doubt.place.z(), doubt.element.empty() ? "" : " on ",
                  doubt.element.c_str(), doubt.what.c_str());
    report_warning(part, line);
  }
}

void say_creases_off(const std::string& part, const TessellationReport& report) {
  char line[160];
  std::snprintf(
      line, sizeof line,
      "cracks of the scan were closed, or it was thinned out, before its creases were found: "
      "they lie up to %.6g off its own triangles",
      report.crease_offset);
  report_warning(part, line);
}

ExitStatus run(Options& options, const CommonOptions& common) {
  Stopwatch whole;
  Result<std::vector<MeshTarget>> targets = targets_of(options, common);
  if (!targets) return report(targets.error());
  Stopwatch watch;
  const Loaded<CompoundSurface> surface = load_surface(options.part);
  if (!surface.value) return surface.status;
  Exporter exporter(options, common, *surface.value, std::move(*targets));
  ExportReport& figures = exporter.figures();
  figures.seconds.parse = watch.lap();
  figures.threads = thread_count(common.threads);
  if (Status made = exporter.make_all(); !made) return report(made.error());
  if (common.json || !options.report_path.empty()) {
    figures.scan = scan_figures(*surface.value, common.threads);
  }
  if (Status done = exporter.finish(whole); !done) return report(done.error());
  for (const auto& [path, note] : exporter.notes()) report_warning(path, note);
  const bool to_stdout = std::count(options.outputs.begin(), options.outputs.end(), "-") > 0;
  ExitStatus printed = ExitStatus::kDone;
  if (common.json) {
    printed = print(to_json(figures, true) + "\n");
  } else if (!common.quiet && !to_stdout) {
    printed = print(exporter.summary());
  }
  if (printed != ExitStatus::kDone) return printed;
  const bool kept = is_kept(figures.surface), closed = !options.solid || figures.surface.watertight;
  if (!kept) say_not_kept(options.part, figures.surface);
  if (figures.surface.crease_offset > 0) say_creases_off(options.part, figures.surface);
  if (!closed) report_warning(options.part, "the solid that --solid asks for is not closed");
  return kept && closed ? ExitStatus::kDone : ExitStatus::kNotKept;
}

Run setup(CLI::App& app) {
  const auto options = std::make_shared<Options>();
  Options& to = *options;
  app.add_option("PART", to.part, "part program (.part)")->required()->type_name("");
  app.add_option("-o,--output", to.outputs, "files to write, told by their endings; - is stdout")
      ->required()
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->type_name("OUT...");
  // `-o a.stl b.obj`: the words after the first are further outputs.
  app.add_option("OUT", to.more_outputs, "further files to write")->type_name("");
  add_stdout_format(app, to.stdout_format);
  add_number(app, "--tolerance", to.tolerance, "largest distance from the surface (default: TOLER)",
             kPositive);
  add_choice(app, "--mesh", to.scheme, kSchemes,
             "as few triangles as the tolerance needs, or the grid array");
  app.add_flag_callback(
      "--no-creases", [options] { options->creases = false; },
      "with --mesh grid: leave the edge points out, for comparison");
  add_number(app, "--feature-angle", to.feature_angle,
             "on a scanned base: edges that turn by more degrees are creases (default: 30)",
             kPositive);
  add_flag_with_number(app, "--solid", to.solid, to.floor,
                       "close it with skirts and a floor at =FLOOR");
  app.add_flag("--lines", to.lines, "crease and edge curves as lines");
  add_choice(app, "--split", to.groups, kGroups, "what becomes a group of its own in the files");
  add_size(app, "--tiles", to.tiles, "NXxNY", "a file a tile, OUT with _i_j before its ending",
           1000);
  add_mesh_output_options(app, to.mesh);
  app.add_option("--report", to.report_path, "the figures of --json into a file")
      ->type_name("FILE.json");
  return [options](const CommonOptions& common) { return run(*options, common); };
}

}  // namespace

const Command kExportCommand{"export", "tessellate a part program and write meshes",
                             "diesink export fixtures/parts/fig6.part -o fig6.stl fig6.glb", true,
                             setup};

}  // namespace diesink
