// `diesink verify`: a tool path, whoever made it, against the surface it is for.
// SPDX-License-Identifier: Apache-2.0
#include <CLI/App.hpp>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "convert/arguments.h"
#include "convert/commands.h"
#include "convert/input.h"
#include "convert/lattice_map.h"
#include "convert/path_check.h"
#include "convert/path_input.h"
#include "convert/paths.h"
#include "convert/text_table.h"
#include "core/counted.h"
#include "formats/output_file.h"
#include "formats/png_image.h"
#include "formats/text_number.h"

namespace diesink {
namespace {

struct Options : CheckRequest {
  std::string part, path, map;
};

struct Color {
  double r, g, b;
};

Color mixed(const Color& a, const Color& b, double t) {
  return {a.r + t * (b.r - a.r), a.g + t * (b.g - a.g), a.b + t * (b.b - a.b)};
}

// Red where it is gouged, green to the limit, yellow to blue where more stays, grey out of reach.
Color color_of(CutState state, double height, double intol, double limit) {
  constexpr Color kGood{0.16, 0.62, 0.36}, kFull{0.85, 0.83, 0.25}, kMuch{0.16, 0.32, 0.75};
  constexpr Color kGouge{0.85, 0.10, 0.12};
  switch (state) {
    case CutState::kNoSurface:
      return {1, 1, 1};
    case CutState::kUnreachable:
      return {0.62, 0.62, 0.62};
    case CutState::kUncut:
      return {0.05, 0.05, 0.25};
    case CutState::kCut:
      break;
  }
  if (height < -intol) return kGouge;
  if (height <= limit) return mixed(kGood, kFull, limit > 0 ? std::fmax(0, height) / limit : 0);
  return mixed(kFull, kMuch, std::fmin(1, (height - limit) / (4 * limit + 1e-12)));
}

Status write_map(const VerifyReport& found, const VerifyOptions& how, const std::string& target) {
  constexpr std::size_t kMostPixels = 2000;  // a side
  const LatticeMap map = thinned(found, how.intol, kMostPixels);
  std::vector<std::uint8_t> rgb(3 * map.points.size());
  for (std::size_t y = 0; y < map.rows; ++y) {
    for (std::size_t x = 0; x < map.columns; ++x) {
      const std::size_t k = map.points[y * map.columns + x];
      const Color c =
          color_of(found.state[k], static_cast<double>(found.height[k]), how.intol, found.limit);
      std::uint8_t* at = rgb.data() + 3 * ((map.rows - 1 - y) * map.columns + x);
      at[0] = static_cast<std::uint8_t>(std::lround(255 * c.r));
      at[1] = static_cast<std::uint8_t>(std::lround(255 * c.g));
      at[2] = static_cast<std::uint8_t>(std::lround(255 * c.b));
    }
  }
  OutputFiles files;
  Result<ByteSink*> sink = files.open(target);
  if (!sink) return sink.error();
  if (Status done = write_png(map.columns, map.rows, rgb, **sink); !done) return done;
  return files.commit();
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

std::string as_table(const VerifyReport& r) {
  const auto at = [](const Vec3& p) {
    return number(p.x()) + " " + number(p.y()) + " " + number(p.z());
  };
  return to_table(
      {{"what", "value", "where"},
       {"largest gouge", number(r.max_gouge), r.max_gouge > 0 ? at(r.max_gouge_at) : "-"},
       {"  not larger than", number(r.max_gouge + r.bound), "-"},
       {"largest excess", number(r.max_excess), at(r.max_excess_at)},
       {"  not larger than", number(r.max_excess + r.excess_bound),
        number(100 * r.proven_part) + " % proven within the limit"},
       {"cusp height, half below", number(r.cusp_p50), "-"},
       {"  99 % below", number(r.cusp_p99), "-"},
       {"  all below", number(r.cusp_max), "-"},
       {"limit (OUTTOL + cusp)", number(r.limit), "-"},
       {"area over the limit", number(r.uncut_area), "-"},
       {"area out of reach", number(r.unreachable_area), "-"},
       {"rapid moves into the part's height", std::to_string(r.rapid_plunges), "-"},
       {"points", std::to_string(r.points), "-"},
       {"length", number(r.length), "-"}});
}

ExitStatus run(const Options& options, const CommonOptions& common) {
  if (!options.map.empty()) {
    if (Status there = check_folder(options.map); !there) return report(there.error());
    if (!has_ending(options.map, ".png")) {
      return report_usage("--map: '" + options.map + "' must end in .png");
    }
  }
  const Loaded<CompoundSurface> loaded = load_surface(options.part);
  if (!loaded.value) return loaded.status;
  const PartProgram& program = loaded.value->program();
  Loaded<PathInput> path = PathInput::open(options.path);
  if (!path.value) return path.status;
  ToolPath head = path.value->head();
  to_unit(head, program.unit);
  Result<VerifyOptions> how = verify_options(options, head, program, options.path);
  if (!how) return report(how.error());
  Progress progress("verifying", common.quiet);
  how->threads = common.threads;
  how->progress = [&](double part) { progress.update(0.2 + 0.8 * part); };
  const Result<Tessellation> mesh = wide_mesh(*loaded.value, *how);
  if (!mesh) return report(mesh.error());
  const double deviation = mesh->report.deviation_where_certified();
  const Result<VerifyReport> found = verify_path(
      *loaded.value, mesh->mesh, deviation,
      [&](const PathTaker& take) { return path.value->points(program.unit, take); }, *how);
  if (!found) {
    Error error = found.error();
    if (error.where.file.empty()) error.where.file = options.path;
    return report(error);
  }
  if (!options.map.empty()) {
    if (Status done = write_map(*found, *how, options.map); !done) return report(done.error());
  }
  const ExitStatus printed = common.json    ? print(to_json(*found) + "\n")
                             : common.quiet ? ExitStatus::kDone
                                            : print(as_table(*found));
  if (printed != ExitStatus::kDone) return printed;
  if (mesh->report.uncertified_area > 0) {
    report_warning(options.part, "the surface is not certified over an area of " +
                                     to_text(mesh->report.uncertified_area) +
                                     ": gouges there may be missed between lattice points");
  }
  if (found->rapid_plunges > 0) {
    report_warning(options.path,
                   counted(found->rapid_plunges,
                           "rapid move goes|rapid moves go| down to or across the part below its "
                           "highest point"));
  }
  if (found->uncut_area > 0) {
    report_warning(options.path, "more than the limit of " + number(found->limit) +
                                     " stays over an area of " + number(found->uncut_area));
  }
  return is_kept(*found, *how) ? ExitStatus::kDone : ExitStatus::kNotKept;
}

Run setup(CLI::App& app) {
  const auto o = std::make_shared<Options>();
  app.add_option("PART", o->part, "part program (.part)")->required()->type_name("");
  app.add_option("PATHS", o->path, "tool path: APT, G-code or CSV (- is stdin)")
      ->required()
      ->type_name("");
  add_cutter(app, o->cutter, "diameter and corner radius (default: the path's, else CUTTER)");
  add_number(app, "--intol", o->intol, "gouge allowed (default: the path's, else INTOL or TOLER)",
             kNotNegative);
  add_number(app, "--outtol", o->outtol,
             "excess allowed (default: the path's, else OUTTOL or TOLER)", kNotNegative);
  add_number(app, "--cusp", o->cusp, "cusp height allowed besides (default: CUSP)", kPositive);
  add_number(app, "--spacing", o->spacing,
             "of the lattice of cusp heights (default: an eightieth of the cutter)", kPositive);
  app.add_option("--map", o->map, "what stays, as a coloured picture")->type_name("OUT.png");
  return [o](const CommonOptions& common) { return run(*o, common); };
}

}  // namespace

const Command kVerifyCommand{
    "verify", "check a tool path against the surface: gouge, excess, cusps",
    "diesink verify fixtures/parts/fig6.part fig6.apt --map fig6.png", true, setup};

}  // namespace diesink
