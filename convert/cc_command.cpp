// `diesink cc`: CC-data of the grid array or of given plan points, and the edge pairs.
// SPDX-License-Identifier: Apache-2.0
#include <CLI/App.hpp>
#include <memory>
#include <string>
#include <vector>

#include "convert/commands.h"
#include "convert/input.h"
#include "convert/paths.h"
#include "core/grid/edges.h"
#include "core/parallel.h"
#include "formats/csv_cc_data.h"
#include "formats/csv_points.h"
#include "formats/input_file.h"
#include "formats/json_writer.h"
#include "formats/output_file.h"

namespace diesink {
namespace {

struct Options {
  std::string part, output, points, edges;
};

enum class Form { kCsv, kJson };

Error usage(std::string message) {
  return {ErrorCode::kUsage, std::move(message), {"diesink", 0, 0, -1}};
}

// stdout is CSV.
Result<Form> form_of(const std::string& path) {
  if (path == "-" || has_ending(path, ".csv")) return Form::kCsv;
  if (has_ending(path, ".json")) return Form::kJson;
  return usage("'" + path + "' has no ending that can be written: .csv .json");
}

// The point data and the edges of one run, before they are written.
struct CcData {
  GridArray grid;               // where no points are given
  std::vector<CcPoint> points;  // over the points of --at
  std::vector<EdgePair> edges;
};

Status evaluate_points(const CompoundSurface& surface, const std::string& path, CcData& data,
                       Diagnostics& diagnostics) {
  const Result<InputBytes> file = read_file(path);
  if (!file) return file.error();
  const std::span<const std::byte> bytes = file->bytes();
  const std::vector<Vec2> places =
      read_csv_points({reinterpret_cast<const char*>(bytes.data()), bytes.size()},
                      path == "-" ? "stdin" : path, diagnostics);
  if (diagnostics.has_errors()) return ok();
  data.points.reserve(places.size());
  for (const Vec2& place : places) {
    data.points.push_back({place.x(), place.y(), surface.at(place.x(), place.y())});
  }
  return ok();
}

Status write_points(const CompoundSurface& surface, const Options& options, const CcData& data,
                    OutputFiles& files) {
  const Result<Form> form = form_of(options.output);
  if (!form) return form.error();
  Result<ByteSink*> sink = files.open(options.output);
  if (!sink) return sink.error();
  ByteSink& to = **sink;
  if (!options.points.empty()) {
    return *form == Form::kCsv ? write_cc_csv(data.points, to)
                               : write_cc_json(surface, data.points, to);
  }
  return *form == Form::kCsv ? write_cc_csv(surface, data.grid, to)
                             : write_cc_json(surface, data.grid, to);
}

Status write_edges(const CompoundSurface& surface, const Options& options, const CcData& data,
                   OutputFiles& files) {
  if (options.edges.empty()) return ok();
  const Result<Form> form = form_of(options.edges);
  if (!form) return form.error();
  Result<ByteSink*> sink = files.open(options.edges);
  if (!sink) return sink.error();
  return *form == Form::kCsv ? write_edges_csv(data.edges, **sink)
                             : write_edges_json(surface, data.edges, **sink);
}

// Wrong usage is found before anything is evaluated.
Status check(const Options& options, const CommonOptions& common) {
  for (const std::string& path : {options.output, options.edges}) {
    if (path.empty()) continue;
    if (const Result<Form> form = form_of(path); !form) return form.error();
    if (Status there = check_folder(path); !there) return there;
    if (path == "-" && common.json) return usage("-o - and --json both want stdout");
  }
  if (options.output == options.edges) return usage("--edges needs a file of its own");
  return ok();
}

std::string summary_json(const Options& options, const CcData& data) {
  std::size_t points = 0, holes = 0, creases = 0, ends = 0, jumps = 0;
  if (options.points.empty()) {
    points = data.grid.size();
    for (const Label label : data.grid.label()) holes += label == kNoLabel ? 1 : 0;
  } else {
    points = data.points.size();
    for (const CcPoint& each : data.points) holes += each.datum ? 0 : 1;
  }
  for (const EdgePair& each : data.edges) {
    creases += each.kind == EdgeKind::kCrease ? 1 : 0;
    ends += each.kind == EdgeKind::kEdge ? 1 : 0;
    jumps += each.kind == EdgeKind::kJump ? 1 : 0;
  }
  JsonWriter json;
  json.begin_object().field("points", points).field("without_surface", holes);
  if (options.points.empty()) {
    json.key("grid").begin_array().value(data.grid.columns()).value(data.grid.rows()).end_array();
  }
  if (!options.edges.empty()) {
    json.key("edges")
        .begin_object()
        .field("crease", creases)
        .field("edge", ends)
        .field("jump", jumps);
    json.end_object();
  }
  json.end_object();
  return json.text() + "\n";
}

ExitStatus run(const Options& options, const CommonOptions& common) {
  if (Status checked = check(options, common); !checked) return report(checked.error());
  const Loaded<CompoundSurface> loaded = load_surface(options.part);
  if (!loaded.value) return loaded.status;
  const CompoundSurface& surface = *loaded.value;
  Progress progress("evaluating", common.quiet);
  CcData data;
  if (!options.points.empty()) {
    Diagnostics diagnostics;
    if (Status done = evaluate_points(surface, options.points, data, diagnostics); !done) {
      return report(done.error());
    }
    if (const ExitStatus status = report(diagnostics); status != ExitStatus::kDone) return status;
  }
  if (options.points.empty() || !options.edges.empty()) {
    const Machining& m = surface.program().machining;
    const WorkAmount points{
        grid_line_count(m.x_range, m.x_interval) * grid_line_count(m.y_range, m.y_interval),
        "points"};
    progress.next("evaluating", points);
    const ProgressSpan span(progress.told(), 0, 1);
    Result<GridArray> grid = evaluate_grid(surface, common.threads);
    if (!grid) return report(grid.error());
    data.grid = std::move(*grid);
  }
  if (!options.edges.empty()) {
    progress.next("finding edges", {static_cast<double>(data.grid.size()), "points"});
    const ProgressSpan span(progress.told(), 0, 1);
    data.edges = find_edges(surface, data.grid, common.threads);
  }
  const std::size_t points = options.points.empty() ? data.grid.size() : data.points.size();
  progress.next("writing " + options.output, {static_cast<double>(points), "points"});
  OutputFiles files;
  {
    const ProgressSpan span(progress.told(), 0, 1);
    if (Status done = write_points(surface, options, data, files); !done)
      return report(done.error());
  }
  if (!options.edges.empty()) progress.next("writing " + options.edges);
  if (Status done = write_edges(surface, options, data, files); !done) return report(done.error());
  if (Status done = files.commit(); !done) return report(done.error());
  return common.json ? print(summary_json(options, data)) : ExitStatus::kDone;
}

Run setup(CLI::App& app) {
  const auto options = std::make_shared<Options>();
  app.add_option("PART", options->part, "part program (.part)")->required()->type_name("");
  app.add_option("-o,--output", options->output, "CC-data: .csv, .json, or - for CSV on stdout")
      ->required()
      ->type_name("OUT");
  app.add_option("--at", options->points, "plan points of a CSV (x,y; - is stdin), not the grid's")
      ->type_name("POINTS");
  app.add_option("--edges", options->edges, "the grid's edge pairs: .csv or .json")
      ->type_name("OUT2");
  return [options](const CommonOptions& common) { return run(*options, common); };
}

}  // namespace

const Command kCcCommand{"cc", "CC-data (z, normal, surface) of the grid or of given points",
                         "diesink cc fixtures/parts/fig6.part -o fig6.csv --edges edges.csv", true,
                         setup};

}  // namespace diesink
