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
#include "convert/paths.h"
#include "convert/text_table.h"
#include "core/machining/verify.h"
#include "core/machining/wide_surface.h"
#include "core/tessellate/tessellate.h"
#include "formats/input_file.h"
#include "formats/json_writer.h"
#include "formats/output_file.h"
#include "formats/path_file.h"
#include "formats/png_image.h"
#include "formats/text_number.h"

namespace diesink {
namespace {

struct Options {
  std::string part, path, map;
  std::optional<std::array<double, 2>> cutter;
  std::optional<double> cusp, intol, outtol, spacing;
};

// Of the mesh under the search for gouges, as a part of the tolerances' sum.
constexpr double kMeshPart = 1.0 / 32;

Loaded<ToolPath> load_path(const std::string& name) {
  const Result<InputBytes> file = read_file(name);
  if (!file) return {std::nullopt, report(file.error())};
  const std::span<const std::byte> bytes = file->bytes();
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::string shown = name == "-" ? "stdin" : name;
  const std::optional<PathFormat> format = path_format_of_content(text, name);
  if (!format) {
    return {std::nullopt,
            report(Error{ErrorCode::kInput,
                         "no tool path that is known; expected APT, G-code or CSV (x,y,z,motion)",
                         {shown, 0, 0, -1}})};
  }
  Diagnostics diagnostics;
  std::optional<ToolPath> path = read_path(text, shown, *format, diagnostics);
  return {std::move(path), report(diagnostics)};
}

// Into the part program's unit.
void to_unit(ToolPath& path, LengthUnit unit) {
  const double scale = metres_per(path.unit) / metres_per(unit);
  path.unit = unit;
  if (scale == 1) return;
  for (ClPoint& point : path.points) point.tip *= scale;
  if (path.cutter)
    path.cutter = Cutter{path.cutter->diameter * scale, path.cutter->corner_radius * scale};
  path.intol *= scale;
  path.outtol *= scale;
}

Result<VerifyOptions> verify_options(const Options& options, const ToolPath& path,
                                     const PartProgram& program) {
  const Machining& m = program.machining;
  VerifyOptions how;
  const std::optional<Cutter> cutter =
      options.cutter ? std::optional<Cutter>({(*options.cutter)[0], (*options.cutter)[1]})
      : path.cutter  ? path.cutter
                     : m.cutter;
  if (!cutter) {
    return Error{
        ErrorCode::kInput,
        "no cutter: the path states none; expected CUTTER,d,r in MACHI-DEF or --cutter D,R",
        {options.path, 0, 0, -1}};
  }
  how.cutter = *cutter;
  how.intol = options.intol.value_or(path.intol > 0 ? path.intol : m.intol.value_or(m.tolerance));
  how.outtol =
      options.outtol.value_or(path.outtol > 0 ? path.outtol : m.outtol.value_or(m.tolerance));
  how.cusp = options.cusp ? options.cusp : m.cusp;
  how.spacing = options.spacing;
  return how;
}

// The part with a margin: material around the domain counts.
Result<Tessellation> wide_mesh(const CompoundSurface& part, const VerifyOptions& how) {
  const Result<CompoundSurface> surface = widened(part, how.cutter.diameter / 2);
  if (!surface) return surface.error();
  TessellationOptions options;
  const double tolerances = how.intol + how.outtol;
  options.tolerance =
      (tolerances > 0 ? tolerances : part.program().machining.tolerance) * kMeshPart;
  options.threads = how.threads;
  return tessellate(*surface, options);
}

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
  const std::size_t every = std::max<std::size_t>(
      1, (std::max(found.columns, found.rows) + kMostPixels - 1) / kMostPixels);
  const std::size_t width = (found.columns + every - 1) / every,
                    height = (found.rows + every - 1) / every;
  std::vector<std::uint8_t> rgb(3 * width * height);
  const auto worse = [&](std::size_t a, std::size_t b) {
    // Of the lattice points under one pixel the one that stands out most.
    const auto weight = [&](std::size_t k) {
      const double h = static_cast<double>(found.height[k]);
      if (found.state[k] != CutState::kCut) return found.state[k] == CutState::kUncut ? 1e6 : 0.0;
      return h < -how.intol ? 1e9 - h : 1 + std::fmax(0, h);
    };
    return weight(b) > weight(a) ? b : a;
  };
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < width; ++x) {
      std::size_t k = y * every * found.columns + x * every;
      for (std::size_t j = y * every; j < std::min((y + 1) * every, found.rows); ++j) {
        for (std::size_t i = x * every; i < std::min((x + 1) * every, found.columns); ++i) {
          k = worse(k, j * found.columns + i);
        }
      }
      const Color c =
          color_of(found.state[k], static_cast<double>(found.height[k]), how.intol, found.limit);
      std::uint8_t* at = rgb.data() + 3 * ((height - 1 - y) * width + x);
      at[0] = static_cast<std::uint8_t>(std::lround(255 * c.r));
      at[1] = static_cast<std::uint8_t>(std::lround(255 * c.g));
      at[2] = static_cast<std::uint8_t>(std::lround(255 * c.b));
    }
  }
  OutputFiles files;
  Result<ByteSink*> sink = files.open(target);
  if (!sink) return sink.error();
  if (Status done = write_png(width, height, rgb, **sink); !done) return done;
  return files.commit();
}

void place(JsonWriter& json, std::string_view key, const Vec3& p) {
  json.key(key).begin_array().value(p.x()).value(p.y()).value(p.z()).end_array();
}

std::string as_json(const VerifyReport& r) {
  JsonWriter json;
  json.begin_object().field("max_gouge", r.max_gouge);
  place(json, "max_gouge_at", r.max_gouge_at);
  json.field("max_excess", r.max_excess);
  place(json, "max_excess_at", r.max_excess_at);
  json.field("cusp_p50", r.cusp_p50)
      .field("cusp_p99", r.cusp_p99)
      .field("cusp_max", r.cusp_max)
      .field("uncut_area", r.uncut_area)
      .field("bound", r.bound)
      .field("points", r.points)
      .field("length", r.length)
      .field("limit", r.limit)
      .field("unreachable_area", r.unreachable_area)
      .field("rapid_plunges", r.rapid_plunges)
      .field("spacing", r.spacing)
      .end_object();
  return json.text() + "\n";
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
  Loaded<ToolPath> path = load_path(options.path);
  if (!path.value) return path.status;
  to_unit(*path.value, program.unit);
  Result<VerifyOptions> how = verify_options(options, *path.value, program);
  if (!how) return report(how.error());
  Progress progress("verifying", common.quiet);
  how->threads = common.threads;
  how->progress = [&](double part) { progress.update(0.2 + 0.8 * part); };
  const Result<Tessellation> mesh = wide_mesh(*loaded.value, *how);
  if (!mesh) return report(mesh.error());
  const double deviation = mesh->report.certified_deviation;
  const Result<VerifyReport> found =
      verify_path(*loaded.value, mesh->mesh, deviation, *path.value, *how);
  if (!found) {
    Error error = found.error();
    if (error.where.file.empty()) error.where.file = options.path;
    return report(error);
  }
  if (!options.map.empty()) {
    if (Status done = write_map(*found, *how, options.map); !done) return report(done.error());
  }
  const ExitStatus printed = common.json    ? print(as_json(*found))
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
                   std::to_string(found->rapid_plunges) +
                       " rapid moves go down to or across the part below its highest point");
  }
  if (found->uncut_area > 0) {
    report_warning(options.path, "more than the limit of " + number(found->limit) +
                                     " stays over an area of " + number(found->uncut_area));
  }
  // A gouge is certain only beyond what the mesh and the search may be off.
  const bool gouged = found->max_gouge - found->bound > how->intol;
  return gouged || found->rapid_plunges > 0 ? ExitStatus::kNotKept : ExitStatus::kDone;
}

Run setup(CLI::App& app) {
  const auto o = std::make_shared<Options>();
  app.add_option("PART", o->part, "part program (.part)")->required()->type_name("");
  app.add_option("PATHS", o->path, "tool path: APT, G-code or CSV (- is stdin)")
      ->required()
      ->type_name("");
  add_number_pair(app, "--cutter", o->cutter, "D,R",
                  "diameter and corner radius (default: the path's, else CUTTER)", kNotNegative);
  add_number(app, "--intol", o->intol, "gouge allowed (default: the path's, else INTOL or TOLER)",
             kNotNegative);
  add_number(app, "--outtol", o->outtol,
             "excess allowed (default: the path's, else OUTTOL or TOLER)", kNotNegative);
  add_number(app, "--cusp", o->cusp, "cusp height allowed besides (default: CUSP)", kPositive);
  add_number(app, "--spacing", o->spacing,
             "of the lattice of cusp heights (default: a fortieth of the cutter)", kPositive);
  app.add_option("--map", o->map, "what stays, as a coloured picture")->type_name("OUT.png");
  return [o](const CommonOptions& common) { return run(*o, common); };
}

}  // namespace

const Command kVerifyCommand{
    "verify", "check a tool path against the surface: gouge, excess, cusps",
    "diesink verify fixtures/parts/fig6.part fig6.apt --map fig6.png", true, setup};

}  // namespace diesink
