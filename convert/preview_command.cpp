// `diesink preview`: a shaded picture of a part program or a mesh.
// SPDX-License-Identifier: Apache-2.0
#include <CLI/App.hpp>
#include <memory>
#include <string>

#include "convert/arguments.h"
#include "convert/commands.h"
#include "convert/input.h"
#include "convert/mesh_input.h"
#include "convert/paths.h"
#include "formats/json_writer.h"
#include "formats/output_file.h"
#include "formats/png_image.h"
#include "picture/preview.h"

namespace diesink {
namespace {

struct Options {
  std::string file, output;
  PreviewOptions picture;
  MeshInputOptions in;
};

constexpr int kMostPixels = 8192;  // a side

constexpr std::array kViews{Choice{"plan", static_cast<int>(View::kPlan)},
                            Choice{"iso", static_cast<int>(View::kIso)},
                            Choice{"front", static_cast<int>(View::kFront)},
                            Choice{"right", static_cast<int>(View::kRight)}};
constexpr std::array kColorings{Choice{"element", static_cast<int>(Coloring::kElement)},
                                Choice{"height", static_cast<int>(Coloring::kHeight)},
                                Choice{"slope", static_cast<int>(Coloring::kSlope)},
                                Choice{"deviation", static_cast<int>(Coloring::kDeviation)}};

// The picture of the file's content, or what went wrong, told.
Loaded<Picture> make_picture(std::span<const std::byte> bytes, const Options& options,
                             const CommonOptions& common) {
  Diagnostics diagnostics;
  const auto told = [&](Result<Picture> picture) -> Loaded<Picture> {
    if (picture) return {std::move(*picture), ExitStatus::kDone};
    Error error = picture.error();
    if (error.where.file.empty()) error.where.file = options.file;
    return {std::nullopt, report(error)};
  };
  PreviewOptions how = options.picture;
  how.threads = common.threads;
  const WorkAmount pixels{static_cast<double>(how.size[0]) * how.size[1], "pixels"};
  if (is_part_program(bytes, options.file)) {
    const Loaded<PartProgram> program = load_part_program(bytes, options.file, diagnostics);
    if (!program.value) return {std::nullopt, program.status};
    const Loaded<CompoundSurface> surface = make_surface(*program.value);
    if (!surface.value) return {std::nullopt, surface.status};
    const Progress progress("drawing", common.quiet, pixels);
    how.progress = progress.told();
    return told(preview(*surface.value, how));
  }
  const Loaded<MeshFile> mesh = load_mesh(bytes, options.file, options.in, common, diagnostics);
  if (!mesh.value) return {std::nullopt, mesh.status};
  const Progress progress("drawing", common.quiet, pixels);
  how.progress = progress.told();
  return told(preview(mesh.value->mesh, how));
}

Status write_picture(const Picture& picture, const std::string& target) {
  OutputFiles files;
  Result<ByteSink*> sink = files.open(target);
  if (!sink) return sink.error();
  if (Status done = write_png(picture.width, picture.height, picture.rgb, **sink); !done)
    return done;
  return files.commit();
}

ExitStatus run(const Options& options, const CommonOptions& common) {
  if (!has_ending(options.output, ".png")) {
    return report_usage("-o: '" + options.output + "' must end in .png");
  }
  if (Status there = check_folder(options.output); !there) return report(there.error());
  Stopwatch watch;
  const Result<InputBytes> file = read_file(options.file, max_bytes_of(options.in), common.threads);
  if (!file) return report(file.error());
  const Loaded<Picture> picture = make_picture(file->bytes(), options, common);
  if (!picture.value) return picture.status;
  if (Status done = write_picture(*picture.value, options.output); !done)
    return report(done.error());
  if (!common.json) return ExitStatus::kDone;
  JsonWriter json;
  json.begin_object()
      .field("width", picture.value->width)
      .field("height", picture.value->height)
      .field("seconds", watch.lap())
      .end_object();
  return print(json.text() + "\n");
}

Run setup(CLI::App& app) {
  const auto o = std::make_shared<Options>();
  app.add_option("FILE", o->file, "part program or mesh, told by its content; - is stdin")
      ->required()
      ->type_name("");
  app.add_option("-o,--output", o->output, "the picture")->required()->type_name("OUT.png");
  add_choice(app, "--view", o->picture.view, kViews, "where to look from (default iso)");
  add_size(app, "--size", o->picture.size, "WxH", "pixels (default 1600x1200)", kMostPixels);
  add_choice(app, "--color", o->picture.coloring, kColorings,
             "what the colours tell (default element); deviation: of a part's mesh at TOLER from "
             "its surface");
  app.add_flag("--bare", o->picture.bare, "no legend, scale bar and axes");
  add_mesh_input_options(app, o->in);
  return [o](const CommonOptions& common) { return run(*o, common); };
}

}  // namespace

const Command kPreviewCommand{"preview", "a shaded picture of a part program or a mesh",
                              "diesink preview fixtures/parts/fig6.part -o fig6.png", true, setup};

}  // namespace diesink
