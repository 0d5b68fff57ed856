// `diesink view`: one page that shows a part, a mesh or a tool path in a browser.
// SPDX-License-Identifier: Apache-2.0
#include <CLI/App.hpp>
#include <memory>
#include <string>
#include <vector>

#include "convert/arguments.h"
#include "convert/commands.h"
#include "convert/paths.h"
#include "convert/view_scene.h"
#include "core/parallel.h"
#include "formats/json_writer.h"
#include "formats/output_file.h"

namespace diesink {
namespace {

struct Options {
  ViewSources sources;
  std::string output;
};

std::string stem_of(const std::string& path) {
  const std::string name = path.substr(path.rfind('/') + 1);
  const std::size_t dot = name.rfind('.');
  return dot == std::string::npos || dot == 0 ? name : name.substr(0, dot);
}

ExitStatus tell(const Scene& scene, const Options& options, std::size_t bytes, double seconds,
                const CommonOptions& common) {
  const std::size_t points = scene.path ? scene.path->points.size() : 0;
  if (!common.json) {
    if (common.quiet || options.output == "-") return ExitStatus::kDone;
    std::string text = scene.title + ":";
    if (!scene.mesh.triangles.empty()) {
      text += " " + std::to_string(scene.mesh.triangles.size()) + " triangles, " +
              std::to_string(scene.elements.size()) + " elements";
    }
    if (points > 0) {
      text += std::string(scene.mesh.triangles.empty() ? " " : ", ") + std::to_string(points) +
              " points of the path";
    }
    return print(text + "\n  " + options.output + "  " + size_text(options.output) + "\n");
  }
  JsonWriter json;
  json.begin_object()
      .field("triangles", static_cast<std::uint64_t>(scene.mesh.triangles.size()))
      .field("elements", static_cast<std::uint64_t>(scene.elements.size()))
      .field("points", static_cast<std::uint64_t>(points))
      .field("bytes", static_cast<std::uint64_t>(bytes))
      .field("seconds", seconds)
      .end_object();
  return print(json.text() + "\n");
}

ExitStatus run(const Options& options, const CommonOptions& common) {
  const bool to_stdout = options.output == "-";
  if (!to_stdout && !has_ending(options.output, ".html") && !has_ending(options.output, ".htm")) {
    return report_usage("-o: '" + options.output + "' must end in .html");
  }
  if (Status able = can_view(); !able) return report(able.error());
  if (to_stdout && common.json) return report_usage("-o - and --json both want stdout");
  if (Status there = check_folder(options.output); !there) return report(there.error());
  Stopwatch watch;
  Loaded<Scene> scene = load_scene(options.sources, common);
  if (!scene.value) return scene.status;
  if (scene.value->title.empty()) scene.value->title = stem_of(options.sources.files[0]);
  const Result<std::string> page = [&] {
    const Progress progress("packing", common.quiet,
                            {static_cast<double>(scene.value->mesh.triangles.size()), "triangles"});
    const ProgressSpan span(progress.told(), 0, 1);
    return viewer_page_of(*scene.value);
  }();
  if (!page) return report(page.error());
  if (Status done = write_file(options.output, *page); !done) return report(done.error());
  return tell(*scene.value, options, page->size(), watch.lap(), common);
}

Run setup(CLI::App& app) {
  const auto o = std::make_shared<Options>();
  app.add_option("FILE", o->sources.files,
                 "part program, mesh or tool path, or one of each, told by their content; a mesh "
                 "beside a part is compared with its surface")
      ->required()
      ->type_name("...");
  app.add_option("-o,--output", o->output, "the page; - is stdout")
      ->required()
      ->type_name("OUT.html");
  add_number(app, "--tolerance", o->sources.tolerance,
             "largest distance of a part's mesh from its surface (default: TOLER)", kPositive);
  add_cutter(app, o->sources.cutter,
             "diameter and corner radius (default: the path's, else CUTTER)");
  app.add_flag("--verify", o->sources.verify,
               "with a part and a path: colours for what the cutter leaves, as verify finds it");
  add_mesh_input_options(app, o->sources.in);
  return [o](const CommonOptions& common) { return run(*o, common); };
}

}  // namespace

const Command kViewCommand{"view", "a page that shows parts, meshes and paths in a browser",
                           "diesink view fixtures/parts/fig6.part -o fig6.html", true, setup};

}  // namespace diesink
