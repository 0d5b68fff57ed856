// `diesink export`: from a part program to meshes in files.
// SPDX-License-Identifier: Apache-2.0
#include <CLI/App.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>

#include "convert/arguments.h"
#include "convert/commands.h"
#include "convert/export_report.h"
#include "convert/input.h"
#include "convert/mesh_groups.h"
#include "convert/mesh_output.h"
#include "convert/paths.h"
#include "core/parallel.h"
#include "formats/output_file.h"

namespace diesink {
namespace {

struct Options {
  std::string part;
  std::vector<std::string> outputs, more_outputs;
  std::string stdout_format = "obj";
  std::optional<double> tolerance, floor;
  MeshScheme scheme = MeshScheme::kAdaptive;
  bool no_creases = false, solid = false, lines = false;
  MeshGroups groups = MeshGroups::kElement;
  std::array<int, 2> tiles{1, 1};
  std::string report_path;
  MeshOutputOptions mesh;
};

constexpr std::array<Choice, 2> kSchemes{{{"adaptive", static_cast<int>(MeshScheme::kAdaptive)},
                                          {"grid", static_cast<int>(MeshScheme::kGrid)}}};
constexpr std::array<Choice, 3> kGroups{{{"element", static_cast<int>(MeshGroups::kElement)},
                                         {"solid", static_cast<int>(MeshGroups::kSolid)},
                                         {"none", static_cast<int>(MeshGroups::kNone)}}};

// Share of the tolerance the tessellator leaves for what the files add: Draco's grid, or rounding
// to 32-bit floats; that needs more only where the tolerance is tiny beside the coordinates.
constexpr double kDracoShare = 0.25;
constexpr double kLeastShare = 0.01;
constexpr double kMostShare = 0.5;

double share_for_files(const std::vector<MeshTarget>& targets, const MeshOutputOptions& options,
                       double tolerance, double largest_coordinate) {
  if (options.draco) return kDracoShare;
  const bool rounded = std::any_of(targets.begin(), targets.end(), [](const MeshTarget& each) {
    return each.format->positions == Keeps::kFloat32;
  });
  // Half a unit in the last of a float's 24 bits, in three axes.
  const double rounding = std::sqrt(3.0) * std::ldexp(largest_coordinate, -24) / tolerance;
  if (!rounded || rounding > kMostShare) return kLeastShare;  // beyond all help: told by the status
  return std::max(kLeastShare, rounding);
}

Error usage(std::string message) {
  return {ErrorCode::kUsage, std::move(message), {"diesink", 0, 0, -1}};
}

Result<std::vector<MeshTarget>> targets_of(Options& options, const CommonOptions& common) {
  options.outputs.insert(options.outputs.end(), options.more_outputs.begin(),
                         options.more_outputs.end());
  const bool to_stdout = std::count(options.outputs.begin(), options.outputs.end(), "-") > 0;
  if (to_stdout && common.json) return usage("-o - and --json both want stdout");
  if (to_stdout && options.tiles != std::array{1, 1}) return usage("--tiles needs files, not -o -");
  if (options.no_creases && (options.scheme != MeshScheme::kGrid || options.solid)) {
    return usage("--no-creases needs --mesh grid, and no --solid");
  }
  return mesh_targets(options.outputs, options.stdout_format, options.mesh);
}

std::string tile_name(const std::array<int, 2>& tile) {
  return "_" + std::to_string(tile[0]) + "_" + std::to_string(tile[1]);
}

// One run of export: the tiles one after the other, all files put in place together at the end.
class Exporter {
 public:
  Exporter(const Options& options, const CommonOptions& common, const CompoundSurface& surface,
           std::vector<MeshTarget> targets)
      : options_(options), common_(common), surface_(surface), targets_(std::move(targets)) {
    tolerance_ = options.tolerance.value_or(surface.program().machining.tolerance);
  }

  ExportReport& figures() { return figures_; }

  Status make_all() {
    const auto& [columns, rows] = options_.tiles;
    for (int j = 0; j < rows; ++j) {
      for (int i = 0; i < columns; ++i) {
        if (Status made = make_tile({i, j}); !made) return made.error();
      }
    }
    return ok();
  }

  // The report file, and everything in place.
  Status finish(Stopwatch& whole) {
    figures_.surface.certified_deviation += written_deviation_;
    Stopwatch watch;
    // The report stands beside the meshes or not at all, so its own last milliseconds are not in
    // it.
    figures_.seconds.total += whole.lap();
    if (!options_.report_path.empty()) {
      Result<ByteSink*> sink = files_.open(options_.report_path);
      if (!sink) return sink.error();
      const std::string text = to_json(figures_, true) + "\n";
      if (Status put = (*sink)->put(std::as_bytes(std::span(text))); !put) return put.error();
    }
    if (Status done = files_.commit(); !done) return done.error();
    figures_.seconds.write += watch.lap();
    figures_.seconds.total += whole.lap();
    return ok();
  }

  void say_notes() const {
    for (const auto& [path, note] : notes_) report_warning(path, note);
  }

  // What was written, for people.
  [[nodiscard]] std::string summary() const {
    const TessellationReport& report = figures_.surface;
    char line[256];
    std::snprintf(line, sizeof line,
                  "%s: %zu triangles, %zu vertices, %zu elements; deviation at most %.3g "
                  "(tolerance %.3g); %.3f s\n",
                  surface_.program().name.c_str(), figures_.triangles, figures_.vertices,
                  report.elements.size(), report.certified_deviation, report.tolerance,
                  figures_.seconds.total);
    std::string text = line;
    for (const std::string& path : written_) text += "  " + path + "  " + size_text(path) + "\n";
    return text;
  }

 private:
  Status make_tile(const std::array<int, 2>& tile) {
    progress_.next("tessellating");
    TessellationOptions how;
    how.scheme = options_.scheme;
    how.creases = !options_.no_creases;
    how.tolerance =
        tolerance_ * (1 - share_for_files(targets_, options_.mesh, tolerance_, surface_.size()));
    how.solid = options_.solid;
    how.floor = options_.floor;
    how.tiles = options_.tiles;
    how.tile = tile;
    how.threads = common_.threads;
    const double count = options_.tiles[0] * options_.tiles[1];
    const double before = tile[1] * options_.tiles[0] + tile[0];
    how.progress = [&](double part) { progress_.update((before + part) / count); };
    Result<Tessellation> made = tessellate(surface_, how);
    if (!made) return made.error();
    add_tile(figures_, *made, before == 0);
    figures_.surface.tolerance = tolerance_;
    Stopwatch watch;
    progress_.next("writing");
    group_triangles(made->mesh, options_.groups);
    Status written = write_tile(*made, tile);
    figures_.seconds.write += watch.lap();
    return written;
  }

  Status write_tile(const Tessellation& made, const std::array<int, 2>& tile) {
    WriteOptions write;
    write.lines = options_.lines;
    // Writers that quantize keep half of what they are told.
    write.tolerance = 2 * kDracoShare * tolerance_;
    ExportReport own;
    add_tile(own, made, true);
    own.surface.tolerance = tolerance_;
    write.extras_json = to_json(own, false);
    for (const MeshTarget& target : targets_) {
      MeshTarget to = target;
      if (options_.tiles != std::array{1, 1}) to.path = before_ending(target.path, tile_name(tile));
      Result<WrittenMesh> done = write_mesh(files_, to, made.mesh, options_.mesh, write);
      if (!done) return done.error();
      if (options_.lines && target.format->lines == Keeps::kNo) {
        notes_.emplace_back(to.path, std::string(target.format->title) + " keeps no lines");
      }
      written_deviation_ = std::max(written_deviation_, done->deviation);
      for (const std::string& note : done->notes) notes_.emplace_back(to.path, note);
      if (to.path != "-") written_.push_back(to.path);
    }
    return ok();
  }

  const Options& options_;
  const CommonOptions& common_;
  const CompoundSurface& surface_;
  std::vector<MeshTarget> targets_;
  double tolerance_ = 0;
  double written_deviation_ = 0;
  ExportReport figures_;
  OutputFiles files_;
  std::vector<std::pair<std::string, std::string>> notes_;  // path and note
  std::vector<std::string> written_;
  Progress progress_{"tessellating", common_.quiet};
};

void say_not_kept(const std::string& part, const TessellationReport& report) {
  char line[256];
  std::snprintf(
      line, sizeof line,
      "the tolerance %.6g is not certified: deviation up to %.6g, uncertified plan area %.6g",
      report.tolerance, report.certified_deviation, report.uncertified_area);
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
  if (Status done = exporter.finish(whole); !done) return report(done.error());
  exporter.say_notes();
  const bool to_stdout = std::count(options.outputs.begin(), options.outputs.end(), "-") > 0;
  ExitStatus printed = ExitStatus::kDone;
  if (common.json) {
    printed = print(to_json(figures, true) + "\n");
  } else if (!common.quiet && !to_stdout) {
    printed = print(exporter.summary());
  }
  if (printed != ExitStatus::kDone) return printed;
  if (is_kept(figures.surface)) return ExitStatus::kDone;
  say_not_kept(options.part, figures.surface);
  return ExitStatus::kNotKept;
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
  app.add_flag("--no-creases", to.no_creases,
               "with --mesh grid: leave the edge points out, for comparison");
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
