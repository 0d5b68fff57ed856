// `diesink cl`: tool paths for a compound surface as APT, G-code or CSV.
// SPDX-License-Identifier: Apache-2.0
#include <CLI/App.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "convert/arguments.h"
#include "convert/commands.h"
#include "convert/input.h"
#include "convert/path_request.h"
#include "convert/paths.h"
#include "formats/output_file.h"
#include "formats/path_file.h"
#include "formats/text_number.h"

namespace diesink {
namespace {

struct Options : PathRequest {
  std::string part, cc_output;
  std::vector<std::string> outputs;
  AptFlavour flavour = AptFlavour::kApt;
};

constexpr std::array<Choice, 2> kPatterns{{{"zigzag", static_cast<int>(PathPattern::kZigzag)},
                                           {"oneway", static_cast<int>(PathPattern::kOneway)}}};
constexpr std::array<Choice, 2> kMethods{
    {{"drop", static_cast<int>(PathMethod::kDrop)}, {"cc", static_cast<int>(PathMethod::kCc)}}};
constexpr std::array<Choice, 4> kFlavours{{{"apt", static_cast<int>(AptFlavour::kApt)},
                                           {"nx", static_cast<int>(AptFlavour::kNx)},
                                           {"catia", static_cast<int>(AptFlavour::kCatia)},
                                           {"creo", static_cast<int>(AptFlavour::kCreo)}}};

Error usage(std::string message) {
  return {ErrorCode::kUsage, std::move(message), {"diesink", 0, 0, -1}};
}

Result<PathFormat> format_of(const std::string& path) {
  if (path == "-") return PathFormat::kApt;
  if (const std::optional<PathFormat> format = path_format_of_ending(path)) return *format;
  return usage("'" + path + "' has no ending that can be written: " + path_endings());
}

std::string summary(const Options& options, const std::string& name, const PathReport& r,
                    double minutes, double seconds) {
  char line[512];
  std::snprintf(
      line, sizeof line,
      "%s: %zu passes %.4g to %.4g apart, %zu points, %.6g cutting (%.3g min), %.6g rapid; "
      "%.3f s\n",
      name.c_str(), r.passes, r.least_interval, r.greatest_interval, r.points, r.feed_length,
      minutes, r.rapid_length, seconds);
  std::string text = line;
  if (r.added_runs + r.wall_runs > 0) {
    std::snprintf(line, sizeof line, "  %zu runs put in on steep places, %zu along walls\n",
                  r.added_runs, r.wall_runs);
    text += line;
  }
  if (options.method == PathMethod::kDrop) {
    std::snprintf(line, sizeof line,
                  "  cuts at most %.4g too deep, leaves at most %.4g along a pass\n",
                  r.overcut_bound, r.undercut_bound);
  } else {
    std::snprintf(line, sizeof line,
                  "  %zu loops removed, %zu crossings inserted; cuts at most %.4g too deep\n",
                  r.loops_removed, r.crossings_inserted, r.overcut_bound);
  }
  text += line;
  if (r.closing_runs > 0) {
    std::snprintf(line, sizeof line, "  %zu runs over what the passes left\n", r.closing_runs);
    text += line;
  }
  if (r.unreachable_area > 0) {
    std::snprintf(line, sizeof line,
                  "  out of the cutter's reach: an area of %.4g, with up to %.4g left on it; not "
                  "proven: %.4g\n",
                  r.unreachable_area, r.unreachable_height, r.unproven_area);
    text += line;
  }
  for (const std::string& path : options.outputs) {
    if (path != "-") text += "  " + path + "  " + size_text(path) + "\n";
  }
  return text;
}

// All outputs of one path, written as it is planned.
class PathOutputs final : public PathReceiver {
 public:
  explicit PathOutputs(const Options& options) : options_(options) {}

  Status begin(const ToolPath& planned) override {
    ToolPath head = planned;
    set_speeds(head, options_);
    PathWriteOptions how;
    how.program_comment = "diesink " DIESINK_VERSION;
    how.flavour = options_.flavour;
    for (const std::string& path : options_.outputs) {
      Result<ByteSink*> sink = files_.open(path);
      if (!sink) return sink.error();
      writers_.push_back(std::make_unique<PathWriter>(*format_of(path), how, **sink));
      if (Status done = writers_.back()->begin(head); !done) return done;
    }
    return ok();
  }

  Status take(std::span<const ClPoint> points) override {
    for (const std::unique_ptr<PathWriter>& writer : writers_) {
      if (Status done = writer->take(points); !done) return done;
    }
    return ok();
  }

  // The CC-data of one stretch; an error is kept until commit().
  void cc(std::span<const CcContact> contacts) {
    if (!cc_status_) return;
    if (!cc_) {
      Result<ByteSink*> sink = files_.open(options_.cc_output);
      if (!sink) {
        cc_status_ = sink.error();
        return;
      }
      cc_ = std::make_unique<ByteWriter>(**sink);
      *cc_ << "pass,x,y,z,nx,ny,nz\n";
    }
    for (const CcContact& c : contacts) {
      *cc_ << stretches_;
      for (const double v : {c.p.x(), c.p.y(), c.p.z(), c.n.x(), c.n.y(), c.n.z()}) {
        *cc_ << ',' << v;
      }
      *cc_ << '\n';
    }
    ++stretches_;
  }

  Status commit() {
    for (const std::unique_ptr<PathWriter>& writer : writers_) {
      if (Status done = writer->finish(); !done) return done;
    }
    if (!cc_status_) return cc_status_;
    if (cc_) {
      if (Status done = cc_->finish(); !done) return done;
    }
    return files_.commit();
  }

 private:
  const Options& options_;
  OutputFiles files_;
  std::vector<std::unique_ptr<PathWriter>> writers_;
  std::unique_ptr<ByteWriter> cc_;
  std::uint64_t stretches_ = 0;
  Status cc_status_ = ok();
};

Status check(const Options& options, const CommonOptions& common) {
  std::vector<std::string> all = options.outputs;
  if (!options.cc_output.empty()) all.push_back(options.cc_output);
  for (const std::string& path : all) {
    if (Status there = check_folder(path); !there) return there;
    if (path == "-" && common.json) return usage("-o - and --json both want stdout");
    if (std::count(all.begin(), all.end(), path) > 1) return usage("'" + path + "' is given twice");
  }
  for (const std::string& path : options.outputs) {
    if (const Result<PathFormat> format = format_of(path); !format) return format.error();
  }
  if (options.interval && options.cusp) return usage("--interval and --cusp exclude each other");
  if (options.method == PathMethod::kDrop &&
      (!options.cc_output.empty() || options.keep_interference)) {
    return usage("--cc and --keep-interference need --method cc");
  }
  return ok();
}

ExitStatus run(const Options& options, const CommonOptions& common) {
  if (Status checked = check(options, common); !checked) return report(checked.error());
  Stopwatch watch;
  const Loaded<CompoundSurface> loaded = load_surface(options.part);
  if (!loaded.value) return loaded.status;
  const PartProgram& program = loaded.value->program();
  Result<PathOptions> how = path_options(options, program);
  if (!how) return report(how.error());
  Progress progress("planning", common.quiet);
  how->threads = common.threads;
  how->progress = [&](double part) { progress.update(part); };
  PathOutputs outputs(options);
  if (!options.cc_output.empty()) {
    how->cc_pass = [&](std::span<const CcContact> contacts) { outputs.cc(contacts); };
  }
  const Result<PathReport> planned = plan_path(*loaded.value, *how, outputs);
  if (!planned) {
    Error error = planned.error();
    if (error.where.file.empty()) error.where.file = program.file;
    return report(error);
  }
  if (Status written = outputs.commit(); !written) return report(written.error());
  const double seconds = watch.lap();
  const PathReport& r = *planned;
  const double minutes = cutting_minutes(r, options, program);
  const bool to_stdout = std::count(options.outputs.begin(), options.outputs.end(), "-") > 0;
  if (common.json) {
    if (const ExitStatus status = print(to_json(r, minutes, seconds) + "\n");
        status != ExitStatus::kDone)
      return status;
  } else if (!common.quiet && !to_stdout) {
    if (const ExitStatus status = print(summary(options, program.name, r, minutes, seconds));
        status != ExitStatus::kDone)
      return status;
  }
  if (r.uncertified_area > 0) {
    report_warning(options.part, "the surface is not certified over an area of " +
                                     to_text(r.uncertified_area) +
                                     ": the path is not proven there");
  }
  if (r.left_area > 0) {
    report_warning(options.part,
                   "more than OUTTOL and the cusp height stays over an area of " +
                       to_text(r.left_area) +
                       (std::isfinite(r.left_height) ? ", up to " + to_text(r.left_height)
                                                     : ", where no move comes over it") +
                       ", where the cutter fits");
  }
  if (r.unsettled_area > 0) {
    report_warning(options.part, "what stays between the passes is not bounded over an area of " +
                                     to_text(r.unsettled_area));
  }
  return is_kept(r, *how) ? ExitStatus::kDone : ExitStatus::kNotKept;
}

Run setup(CLI::App& app) {
  const auto o = std::make_shared<Options>();
  app.add_option("PART", o->part, "part program (.part)")->required()->type_name("");
  app.add_option("-o,--output", o->outputs,
                 "tool path: " + path_endings() + ", or - for APT on stdout")
      ->required()
      ->type_name("OUT");
  add_cutter(app, o->cutter, "diameter and corner radius (default: CUTTER)");
  add_choice(
      app, "--method", o->method, kMethods,
      "drop: the cutter lowered onto the surface; cc: CC-points offset, interferences removed");
  add_choice(app, "--pattern", o->pattern, kPatterns, "order of the passes");
  app.add_option("--along", o->along,
                 "passes along x, y or an angle in degrees; u, v: curves of the base")
      ->type_name("x|y|DEGREES|u|v");
  add_number(app, "--interval", o->interval, "distance between passes (default: Y-INT)", kPositive);
  add_number(app, "--cusp", o->cusp, "cusp height, instead of an interval (default: CUSP)",
             kPositive);
  add_number(app, "--intol", o->intol, "deepest overcut (default: INTOL or TOLER)", kNotNegative);
  add_number(app, "--outtol", o->outtol, "largest undercut (default: OUTTOL or TOLER)",
             kNotNegative);
  add_number(app, "--feed", o->feed, "feed a minute (default: FEDRAT, else 1000 mm or 40 inches)",
             kPositive);
  add_number(app, "--spindle", o->spindle, "turns a minute (default: SPINDL)", kPositive);
  add_number(app, "--clear", o->clear,
             "clearance plane (default: CLEAR, else a diameter above the part)");
  add_choice(app, "--flavour", o->flavour, kFlavours, "word order of APT");
  app.add_option("--cc", o->cc_output, "CC-data with normals of every pass, as CSV (method cc)")
      ->type_name("OUT.csv");
  app.add_flag("--keep-interference", o->keep_interference,
               "leave interferences in, to look at (method cc)");
  return [o](const CommonOptions& common) { return run(*o, common); };
}

}  // namespace

const Command kClCommand{"cl", "tool paths that do not gouge, as APT, G-code or CSV",
                         "diesink cl fixtures/parts/fig6.part --cutter 6,3 --cusp 0.01 -o fig6.apt",
                         true, setup};

}  // namespace diesink
