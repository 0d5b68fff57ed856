// Part programs: loaded, evaluated, tessellated, exported, cut and verified.
// SPDX-License-Identifier: Apache-2.0
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <array>
#include <tuple>

#include "convert/console.h"
#include "convert/export_run.h"
#include "convert/input.h"
#include "convert/path_check.h"
#include "convert/path_input.h"
#include "convert/path_request.h"
#include "core/parallel.h"
#include "formats/input_file.h"
#include "python/arrays.h"
#include "python/bindings.h"

namespace diesink::python {
namespace {

using CutterPair = std::optional<std::array<double, 2>>;

// Runs `work`, which gives a Result, without the interpreter's lock.
template <class Work>
auto unlocked(const Work& work) {
  auto result = [&] {
    const py::gil_scoped_release released;
    return work();
  }();
  return value_or_raise(std::move(result));
}

std::unique_ptr<Part> make_part(const std::string& text, const std::string& name) {
  Diagnostics diagnostics;
  std::optional<CompoundSurface> surface;
  {
    const py::gil_scoped_release released;
    const std::optional<PartProgram> program = parse_part_program(text, name, diagnostics);
    if (program) surface = surface_of(*program, diagnostics);
  }
  if (!surface) raise(diagnostics);
  return std::make_unique<Part>(Part{std::move(*surface), diagnostics.all()});
}

std::unique_ptr<Part> load(const std::filesystem::path& path) {
  const std::string name = file_name(path);
  const Result<InputBytes> file = read_file(name);
  if (!file) raise(file.error());
  const std::span<const std::byte> bytes = file->bytes();
  return make_part({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, name);
}

MeshScheme scheme_of(const std::string& word) {
  return word_of<MeshScheme>("mesh", word, {"adaptive", "grid"});
}

Mesh tessellate_part(const Part& part, std::optional<double> tolerance, const std::string& mesh,
                     bool creases, bool solid, std::optional<double> floor, int threads) {
  check_positive("tolerance", tolerance);
  TessellationOptions how;
  how.tolerance = tolerance.value_or(0);
  how.scheme = scheme_of(mesh);
  how.creases = creases;
  how.solid = solid;
  how.floor = floor;
  how.threads = threads;
  Tessellation made = unlocked([&] { return tessellate(part.surface, how); });
  ExportReport report;
  add_tile(report, made, true);
  report.threads = thread_count(threads);
  Mesh result;
  result.kept = is_kept(report.surface);
  result.report = from_json(to_json(report, true));
  result.mesh = std::make_shared<const TriangleMesh>(std::move(made.mesh));
  return result;
}

// What export_part takes by name.
struct ExportWords {
  std::optional<double> tolerance;
  std::string mesh;
  bool creases, solid;
  std::optional<double> floor;
  bool lines;
  std::string split;
  std::array<int, 2> tiles;
  bool ascii, draco;
  std::optional<int> draco_speed, quantize;
  int threads;
};

ExportOptions export_options(const ExportWords& words) {
  check_positive("tolerance", words.tolerance);
  if (words.tiles[0] < 1 || words.tiles[1] < 1)
    raise_usage("tiles needs two numbers of at least 1");
  if (words.draco_speed && (*words.draco_speed < 0 || *words.draco_speed > 10)) {
    raise_usage("draco_speed needs a number from 0 to 10");
  }
  if (words.quantize && (*words.quantize < 1 || *words.quantize > 30)) {
    raise_usage("quantize needs a number from 1 to 30");
  }
  ExportOptions options;
  options.tolerance = words.tolerance;
  options.scheme = scheme_of(words.mesh);
  options.creases = words.creases;
  options.solid = words.solid;
  options.floor = words.floor;
  options.lines = words.lines;
  options.groups = word_of<MeshGroups>("split", words.split, {"element", "solid", "none"});
  options.tiles = words.tiles;
  options.mesh.ascii = words.ascii;
  options.mesh.draco = words.draco;
  options.mesh.draco_speed = words.draco_speed;
  options.mesh.quantize_bits = words.quantize;
  if (!options.creases && (options.scheme != MeshScheme::kGrid || options.solid)) {
    raise_usage("creases=False needs mesh='grid', and not solid");
  }
  return options;
}

py::object export_part(const Part& part, const py::args& outputs, const ExportWords& words) {
  const ExportOptions options = export_options(words);
  std::vector<std::string> names;
  for (const py::handle each : outputs) {
    names.push_back(file_name(each.cast<std::filesystem::path>()));
  }
  if (names.empty()) raise_usage("export needs at least one file");
  CommonOptions common;
  common.threads = words.threads;
  common.quiet = true;
  std::string report;
  bool kept = true;
  using Notes = std::vector<std::pair<std::string, std::string>>;
  const Notes notes = unlocked([&]() -> Result<Notes> {
    Stopwatch whole;
    Result<std::vector<MeshTarget>> targets = mesh_targets(names, "", options.mesh);
    if (!targets) return targets.error();
    Exporter exporter(options, common, part.surface, std::move(*targets));
    exporter.figures().threads = thread_count(words.threads);
    if (Status made = exporter.make_all(); !made) return made.error();
    if (Status done = exporter.finish(whole); !done) return done.error();
    report = to_json(exporter.figures(), true);
    kept = is_kept(exporter.figures().surface);
    return exporter.notes();
  });
  py::object figures = from_json(report);
  figures["kept"] = py::bool_(kept);
  figures["notes"] = py::cast(notes);
  return figures;
}

// "x", "y", "u", "v" or degrees.
std::string along_of(const std::variant<double, std::string>& along) {
  if (const std::string* word = std::get_if<std::string>(&along)) return *word;
  return py::repr(py::float_(std::get<double>(along))).cast<std::string>();
}

struct PathWords {
  CutterPair cutter;
  std::string method, pattern;
  std::variant<double, std::string> along;
  std::optional<double> interval, cusp, intol, outtol, feed, spindle, clear;
  int threads;
};

PathRequest path_request(const PathWords& words) {
  for (const auto& [name, value] : {std::pair{"interval", words.interval},
                                    {"cusp", words.cusp},
                                    {"feed", words.feed},
                                    {"spindle", words.spindle}}) {
    check_positive(name, value);
  }
  for (const auto& [name, value] : {std::pair{"intol", words.intol}, {"outtol", words.outtol}}) {
    check_not_negative(name, value);
  }
  check_number("clear", words.clear);
  if (words.interval && words.cusp) raise_usage("interval and cusp exclude each other");
  PathRequest request;
  request.cutter = words.cutter;
  request.method = word_of<PathMethod>("method", words.method, {"drop", "cc"});
  request.pattern = word_of<PathPattern>("pattern", words.pattern, {"zigzag", "oneway"});
  request.along = along_of(words.along);
  request.interval = words.interval;
  request.cusp = words.cusp;
  request.intol = words.intol;
  request.outtol = words.outtol;
  request.feed = words.feed;
  request.spindle = words.spindle;
  request.clear = words.clear;
  return request;
}

py::list contacts_of(const PlannedPath& planned) {
  py::list passes;
  for (const std::vector<CcContact>& pass : planned.cc_passes) {
    const auto count = static_cast<py::ssize_t>(pass.size());
    py::array_t<double> points({count, py::ssize_t{3}}), normals({count, py::ssize_t{3}});
    double *to_point = points.mutable_data(), *to_normal = normals.mutable_data();
    for (const CcContact& each : pass) {
      to_point = std::copy_n(each.p.data(), 3, to_point);
      to_normal = std::copy_n(each.n.data(), 3, to_normal);
    }
    passes.append(py::make_tuple(points, normals));
  }
  return passes;
}

Path plan(const Part& part, const PathWords& words) {
  const PathRequest request = path_request(words);
  PathOptions how = value_or_raise(path_options(request, part.surface.program()));
  how.threads = words.threads;
  Stopwatch watch;
  PlannedPath planned = unlocked([&] { return plan_path(part.surface, how); });
  set_speeds(planned.path, request);
  Path path;
  path.kept = is_kept(planned.report, how);
  const double minutes = cutting_minutes(planned.report, request, part.surface.program());
  path.report = from_json(to_json(planned.report, minutes, watch.lap()));
  path.contacts = contacts_of(planned);
  path.path = std::make_shared<const ToolPath>(std::move(planned.path));
  return path;
}

Check verify(const Part& part, const Path& path, const CutterPair& cutter,
             std::optional<double> intol, std::optional<double> outtol, std::optional<double> cusp,
             std::optional<double> spacing, int threads) {
  check_not_negative("intol", intol);
  check_not_negative("outtol", outtol);
  check_positive("cusp", cusp);
  check_positive("spacing", spacing);
  CheckRequest request;
  request.cutter = cutter;
  request.intol = intol;
  request.outtol = outtol;
  request.cusp = cusp;
  request.spacing = spacing;
  const PartProgram& program = part.surface.program();
  ToolPath own = *path.path;
  to_unit(own, program.unit);
  VerifyOptions how = value_or_raise(verify_options(request, own, program, own.name));
  how.threads = threads;
  VerifyReport found = unlocked([&]() -> Result<VerifyReport> {
    const Result<Tessellation> mesh = wide_mesh(part.surface, how);
    if (!mesh) return mesh.error();
    return verify_path(part.surface, mesh->mesh, mesh->report.deviation_where_certified(), own,
                       how);
  });
  Check result;
  result.report = from_json(to_json(found));
  result.kept = is_kept(found, how);
  result.found = std::make_shared<const VerifyReport>(std::move(found));
  return result;
}

// Lattice values, row by row from the domain's low corner.
template <class T>
py::array lattice(const py::object& self, const T* data) {
  const VerifyReport& found = *self.cast<const Check&>().found;
  const auto rows = static_cast<py::ssize_t>(found.rows),
             columns = static_cast<py::ssize_t>(found.columns);
  return view(data, {rows, columns},
              {columns * static_cast<py::ssize_t>(sizeof(T)), static_cast<py::ssize_t>(sizeof(T))},
              self);
}

void add_verification(py::module_& module) {
  py::class_<Check>(module, "Verification", "What a tool path leaves of a part, or takes too much.")
      .def_readonly("report", &Check::report, "The figures of diesink verify --json.")
      .def_readonly(
          "kept", &Check::kept,
          "True where no gouge beyond the tolerance is certain and no rapid move goes into "
          "the part.")
      .def_property_readonly(
          "height",
          [](const py::object& self) {
            return lattice(self, self.cast<const Check&>().found->height.data());
          },
          "What stays over the surface at the lattice's points, negative where it is gouged; "
          "float32, (rows, columns).")
      .def_property_readonly(
          "state",
          [](const py::object& self) {
            return lattice(self, reinterpret_cast<const std::uint8_t*>(
                                     self.cast<const Check&>().found->state.data()));
          },
          "Of each lattice point: 0 no surface, 1 cut, 2 left uncut, 3 out of the cutter's reach.");
}

py::list solids_of(const Part& part) {
  py::list solids;
  for (const Solid& each : part.surface.program().solids) {
    solids.append(py::make_tuple(each.id, py::str(each.type.data(), each.type.size())));
  }
  return solids;
}

py::list boole_of(const Part& part) {
  py::list rows;
  for (int row = 0; row < part.surface.row_count(); ++row) {
    const int surface = part.surface.surface_of_row(row);
    const std::string id =
        surface == 0 ? "B"
                     : part.surface.program().solids[static_cast<std::size_t>(surface) - 1].id;
    rows.append(py::make_tuple(id, static_cast<int>(part.surface.sign_of_row(row))));
  }
  return rows;
}

}  // namespace

void add_part(py::module_& module) {
  add_verification(module);
  py::class_<Part>(module, "Part", "A part program and its compound surface; it does not change.")
      .def_property_readonly(
          "name", [](const Part& p) { return p.surface.program().name; }, "Stem of the file.")
      .def_property_readonly(
          "unit", [](const Part& p) { return std::string(name_of(p.surface.program().unit)); },
          "'mm' or 'inch', of every length.")
      .def_property_readonly(
          "domain",
          [](const Part& p) {
            const Machining& m = p.surface.program().machining;
            return std::tuple(m.x_range[0], m.x_range[1], m.y_range[0], m.y_range[1]);
          },
          "(x0, x1, y0, y1).")
      .def_property_readonly(
          "tolerance", [](const Part& p) { return p.surface.program().machining.tolerance; },
          "TOLER.")
      .def_property_readonly("solids", &solids_of, "(name, type) of every solid, in their order.")
      .def_property_readonly("boole", &boole_of,
                             "The Boolean table: (name, sign) of every row, B the base.")
      .def_readonly("warnings", &Part::warnings, "Diagnostics that were no errors.")
      .def("evaluate", &evaluate, py::arg("x"), py::arg("y"), py::kw_only(), py::arg("threads") = 0,
           "CC-data over the plan points (x, y), which may be numbers or arrays that broadcast.")
      .def("grid", &evaluate_lines, py::arg("x") = py::none(), py::arg("y") = py::none(),
           py::kw_only(), py::arg("threads") = 0,
           "CC-data over all crossings of plan lines, z of shape (len(y), len(x)); without lines "
           "the grid of the part program.")
      .def("tessellate", &tessellate_part, py::kw_only(), py::arg("tolerance") = py::none(),
           py::arg("mesh") = "adaptive", py::arg("creases") = true, py::arg("solid") = false,
           py::arg("floor") = py::none(), py::arg("threads") = 0,
           "A mesh at most tolerance (default TOLER) away from the surface, sharp where elements "
           "meet. mesh: 'adaptive', or 'grid' for the paper's grid array. solid closes it with "
           "skirts and a floor.")
      .def(
          "export",
          [](const Part& part, const py::args& outputs, std::optional<double> tolerance,
             std::string mesh, bool creases, bool solid, std::optional<double> floor, bool lines,
             std::string split, std::array<int, 2> tiles, bool ascii, bool draco,
             std::optional<int> draco_speed, std::optional<int> quantize, int threads) {
            return export_part(
                part, outputs,
                {tolerance, std::move(mesh), creases, solid, floor, lines, std::move(split), tiles,
                 ascii, draco, draco_speed, quantize, threads});
          },
          py::kw_only(), py::arg("tolerance") = py::none(), py::arg("mesh") = "adaptive",
          py::arg("creases") = true, py::arg("solid") = false, py::arg("floor") = py::none(),
          py::arg("lines") = false, py::arg("split") = "element",
          py::arg("tiles") = std::array<int, 2>{1, 1}, py::arg("ascii") = false,
          py::arg("draco") = false, py::arg("draco_speed") = py::none(),
          py::arg("quantize") = py::none(), py::arg("threads") = 0,
          "Tessellates and writes each file by its ending, as diesink export does: all of them or "
          "none. Gives the figures of diesink export --json, with 'kept' and 'notes'.")
      .def(
          "cl",
          [](const Part& part, const CutterPair& cutter, std::string method, std::string pattern,
             std::variant<double, std::string> along, std::optional<double> interval,
             std::optional<double> cusp, std::optional<double> intol, std::optional<double> outtol,
             std::optional<double> feed, std::optional<double> spindle, std::optional<double> clear,
             int threads) {
            return plan(part, {cutter, std::move(method), std::move(pattern), std::move(along),
                               interval, cusp, intol, outtol, feed, spindle, clear, threads});
          },
          py::kw_only(), py::arg("cutter") = py::none(), py::arg("method") = "drop",
          py::arg("pattern") = "zigzag", py::arg("along") = "x", py::arg("interval") = py::none(),
          py::arg("cusp") = py::none(), py::arg("intol") = py::none(),
          py::arg("outtol") = py::none(), py::arg("feed") = py::none(),
          py::arg("spindle") = py::none(), py::arg("clear") = py::none(), py::arg("threads") = 0,
          "A tool path that does not gouge. cutter: (diameter, corner radius); along: 'x', 'y', "
          "'u', 'v' or degrees; what is None is as the part program states it.")
      .def("verify", &verify, py::arg("path"), py::kw_only(), py::arg("cutter") = py::none(),
           py::arg("intol") = py::none(), py::arg("outtol") = py::none(),
           py::arg("cusp") = py::none(), py::arg("spacing") = py::none(), py::arg("threads") = 0,
           "Checks a path over the whole volume it sweeps: gouge, excess and cusps.")
      .def("__repr__", [](const Part& p) {
        return "<diesink.Part " + p.surface.program().name + ": " +
               std::to_string(p.surface.program().solids.size()) + " solids, " +
               std::to_string(p.surface.row_count()) + " terms>";
      });
  module.def("load", &load, py::arg("path"), "Reads and checks a part program.");
  module.def("parse", &make_part, py::arg("text"), py::arg("file") = "program.part",
             "Checks a part program's text; file names it in messages, and its folder is where the "
             "scan of a MESH base is looked for.");
}

}  // namespace diesink::python
