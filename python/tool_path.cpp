// Tool paths as numpy arrays, read from files, made of arrays, and written.
// SPDX-License-Identifier: Apache-2.0
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cmath>

#include "formats/input_file.h"
#include "formats/output_file.h"
#include "formats/path_file.h"
#include "python/arrays.h"
#include "python/bindings.h"

namespace diesink::python {
namespace {

const ToolPath& path_of(const py::object& self) { return *self.cast<const Path&>().path; }

using CutterPair = std::optional<std::pair<double, double>>;

Path make_path(const Given<double>& tips, const std::optional<Given<bool>>& rapid,
               const CutterPair& cutter, const std::string& unit, double feed, double spindle,
               double intol, double outtol, const std::string& name) {
  if (tips.ndim() != 2 || tips.shape(1) != 3) raise_usage("tips needs the shape (n, 3)");
  if (rapid && (rapid->ndim() != 1 || rapid->size() != tips.shape(0))) {
    raise_usage("rapid needs one truth value a tip");
  }
  for (const auto& [what, value] :
       {std::pair{"feed", feed}, {"spindle", spindle}, {"intol", intol}, {"outtol", outtol}}) {
    check_not_negative(what, value);
  }
  auto path = std::make_shared<ToolPath>();
  path->name = name;
  path->unit = word_of<LengthUnit>("unit", unit, {"unknown", "mm", "cm", "m", "inch"});
  if (cutter) path->cutter = Cutter{cutter->first, cutter->second};
  path->feed = feed;
  path->spindle = spindle;
  path->intol = intol;
  path->outtol = outtol;
  for (py::ssize_t k = 0; k < tips.shape(0); ++k) {
    const Vec3 tip(tips.at(k, 0), tips.at(k, 1), tips.at(k, 2));
    if (!tip.allFinite()) raise_usage("tips: row " + std::to_string(k) + " is not finite");
    const bool fast = rapid && rapid->at(k);
    path->points.push_back({tip, fast ? Motion::kRapid : Motion::kFeed});
  }
  return {std::move(path)};
}

py::array tips_of(const py::object& self) {
  const std::vector<ClPoint>& points = path_of(self).points;
  return view(points.empty() ? nullptr : points.front().tip.data(),
              {static_cast<py::ssize_t>(points.size()), 3}, {sizeof(ClPoint), sizeof(double)},
              self);
}

py::array rapid_of(const Path& self) {
  const std::vector<ClPoint>& points = self.path->points;
  py::array_t<bool> rapid(static_cast<py::ssize_t>(points.size()));
  bool* to = rapid.mutable_data();
  for (const ClPoint& each : points) *to++ = each.motion == Motion::kRapid;
  return rapid;
}

void write(const Path& self, const std::filesystem::path& file, const std::string& flavour) {
  const std::string name = file_name(file);
  PathWriteOptions how;
  how.program_comment = "diesink " DIESINK_VERSION;
  how.flavour = word_of<AptFlavour>("flavour", flavour, {"apt", "nx", "catia", "creo"});
  const std::optional<PathFormat> format = path_format_of_ending(name);
  if (!format) {
    raise_usage("'" + name +
                "' has no ending that can be written: .apt .cls .ncl .aptsource .ngc .csv");
  }
  Status done = ok();
  {
    const py::gil_scoped_release unlocked;
    done = [&]() -> Status {
      OutputFiles files;
      Result<ByteSink*> sink = files.open(name);
      if (!sink) return sink.error();
      if (Status put = write_path(*self.path, *format, how, **sink); !put) return put;
      return files.commit();
    }();
  }
  check(done);
}

std::pair<Path, std::vector<Diagnostic>> read(const std::filesystem::path& file) {
  const std::string name = file_name(file);
  Diagnostics diagnostics;
  std::optional<ToolPath> path;
  Status done = ok();
  {
    const py::gil_scoped_release unlocked;
    done = [&]() -> Status {
      const Result<InputBytes> content = read_file(name);
      if (!content) return content.error();
      const std::span<const std::byte> bytes = content->bytes();
      const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
      const std::optional<PathFormat> format = path_format_of_content(text, name);
      if (!format) {
        return Error{ErrorCode::kInput,
                     "no tool path that is known; expected APT, G-code or CSV (x,y,z,motion)",
                     {name, 0, 0, -1}};
      }
      path = read_path(text, name, *format, diagnostics);
      return ok();
    }();
  }
  check(done);
  if (!path) raise(diagnostics);
  return {Path{std::make_shared<const ToolPath>(std::move(*path))}, diagnostics.all()};
}

}  // namespace

void add_tool_path(py::module_& module) {
  py::class_<Path>(module, "ToolPath",
                   "Straight moves of a cutter's tip; its axis is (0, 0, 1).\n\n"
                   "Made of arrays: ToolPath(tips, rapid, cutter=(diameter, corner_radius), ...).")
      .def(py::init(&make_path), py::arg("tips"), py::arg("rapid") = py::none(), py::kw_only(),
           py::arg("cutter") = py::none(), py::arg("unit") = "mm", py::arg("feed") = 0.0,
           py::arg("spindle") = 0.0, py::arg("intol") = 0.0, py::arg("outtol") = 0.0,
           py::arg("name") = "path", "A path of somebody's arrays; without rapid all moves cut.")
      .def_property_readonly("tips", &tips_of, "Ends of the moves, float64, (n, 3); a view.")
      .def_property_readonly("rapid", &rapid_of, "True where the move to that tip is rapid.")
      .def_property_readonly(
          "cutter",
          [](const Path& p) -> CutterPair {
            if (!p.path->cutter) return std::nullopt;
            return std::pair{p.path->cutter->diameter, p.path->cutter->corner_radius};
          },
          "(diameter, corner radius), or None.")
      .def_property_readonly(
          "unit", [](const Path& p) { return std::string(name_of(p.path->unit)); },
          "'mm' or 'inch', of every length.")
      .def_property_readonly(
          "feed", [](const Path& p) { return p.path->feed; }, "Units a minute.")
      .def_property_readonly(
          "spindle", [](const Path& p) { return p.path->spindle; }, "Turns a minute.")
      .def_property_readonly(
          "intol", [](const Path& p) { return p.path->intol; }, "Overcut tolerance.")
      .def_property_readonly(
          "outtol", [](const Path& p) { return p.path->outtol; }, "Undercut tolerance.")
      .def_property_readonly(
          "clearance", [](const Path& p) { return p.path->clearance; },
          "Height of the rapid moves.")
      .def_property_readonly(
          "name", [](const Path& p) { return p.path->name; }, "Its name.")
      .def_readonly("report", &Path::report,
                    "The figures of diesink cl --json; None where it was not planned here.")
      .def_readonly("kept", &Path::kept, "True where the overcut tolerance is proven everywhere.")
      .def_readonly("contacts", &Path::contacts,
                    "Method cc: of each pass the contact points and the unit normals there.")
      .def("write", &write, py::arg("path"), py::kw_only(), py::arg("flavour") = "apt",
           "Writes .apt .cls .ncl .aptsource, .ngc or .csv, whole or not at all.")
      .def("__len__", [](const Path& p) { return p.path->points.size(); })
      .def("__repr__", [](const Path& p) {
        return "<diesink.ToolPath " + p.path->name + ": " + std::to_string(p.path->points.size()) +
               " points>";
      });
  module.def("read_path", &read, py::arg("path"),
             "Reads APT, G-code or CSV, told by its content: the path and the warnings.");
}

}  // namespace diesink::python
