// Meshes as numpy arrays, read from files, made of arrays, and written.
// SPDX-License-Identifier: Apache-2.0
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <cmath>

#include "convert/mesh_output.h"
#include "formats/mesh_file.h"
#include "python/arrays.h"
#include "python/bindings.h"

namespace diesink::python {
namespace {

struct Curve {
  std::shared_ptr<const TriangleMesh> mesh;
  std::size_t index = 0;
  [[nodiscard]] const MeshCurve& curve() const { return mesh->curves[index]; }
};

const TriangleMesh& mesh_of(const py::object& self) { return *self.cast<const Mesh&>().mesh; }

std::vector<std::string> names_of(const TriangleMesh& mesh) {
  std::vector<std::string> names;
  for (const MeshElement& each : mesh.elements) names.push_back(each.name);
  return names;
}

LengthUnit unit_of(const std::string& word) {
  return word_of<LengthUnit>("unit", word, {"unknown", "mm", "cm", "m", "inch"});
}

// Needs: arrays whose shapes are those of their contents.
template <class T>
void check_shape(const char* name, const Given<T>& array, py::ssize_t columns) {
  if (array.ndim() == 2 && array.shape(1) == columns) return;
  raise_usage(std::string(name) + " needs the shape (n, " + std::to_string(columns) + "), got " +
              std::string(py::str(array.attr("shape"))));
}

Mesh make_mesh(const Given<double>& vertices, const Given<std::int64_t>& triangles,
               const std::optional<Given<std::int64_t>>& element,
               const std::vector<std::string>& names, const std::string& unit,
               const std::string& name) {
  check_shape("vertices", vertices, 3);
  check_shape("triangles", triangles, 3);
  auto mesh = std::make_shared<TriangleMesh>();
  mesh->name = name;
  mesh->unit = unit_of(unit);
  mesh->up = UpAxis::kZ;
  for (py::ssize_t k = 0; k < vertices.shape(0); ++k) {
    const double* at = vertices.data(k, 0);
    if (!std::all_of(at, at + 3, [](double v) { return std::isfinite(v); })) {
      raise_usage("vertices: row " + std::to_string(k) + " is not finite");
    }
    mesh->positions.emplace_back(at[0], at[1], at[2]);
  }
  for (py::ssize_t k = 0; k < triangles.shape(0); ++k) {
    const std::int64_t* at = triangles.data(k, 0);
    if (!std::all_of(at, at + 3, [&](std::int64_t v) { return v >= 0 && v < vertices.shape(0); })) {
      raise_usage("triangles: row " + std::to_string(k) + " is outside the " +
                  std::to_string(vertices.shape(0)) + " vertices");
    }
    mesh->triangles.push_back({static_cast<std::uint32_t>(at[0]), static_cast<std::uint32_t>(at[1]),
                               static_cast<std::uint32_t>(at[2])});
  }
  for (const std::string& each : names) {
    mesh->elements.push_back({each, each.substr(0, each.find('.')), std::nullopt});
  }
  if (!element) return {std::move(mesh)};
  if (element->ndim() != 1 || element->size() != triangles.shape(0)) {
    raise_usage("element needs one number a triangle");
  }
  for (py::ssize_t k = 0; k < element->size(); ++k) {
    const std::int64_t index = *element->data(k);
    if (index < 0 || static_cast<std::size_t>(index) >= names.size()) {
      raise_usage("element: entry " + std::to_string(k) + " is outside the " +
                  std::to_string(names.size()) + " names");
    }
    mesh->triangle_element.push_back(static_cast<std::uint32_t>(index));
  }
  return {std::move(mesh)};
}

std::vector<std::string> write(const Mesh& self, const std::filesystem::path& path, bool ascii,
                               bool lines, bool draco) {
  MeshOutputOptions how;
  how.ascii = ascii;
  how.draco = draco;
  const std::string name = file_name(path);
  std::optional<Result<WrittenMesh>> done;
  {
    const py::gil_scoped_release unlocked;
    done = [&]() -> Result<WrittenMesh> {
      const Result<std::vector<MeshTarget>> targets = mesh_targets({name}, "", how);
      if (!targets) return targets.error();
      WriteOptions options;
      options.lines = lines;
      OutputFiles files;
      Result<WrittenMesh> written =
          write_mesh(files, targets->front(), *self.mesh, how, std::move(options));
      if (!written) return written.error();
      if (Status put = files.commit(); !put) return put.error();
      return written;
    }();
  }
  return value_or_raise(std::move(*done)).notes;
}

std::pair<Mesh, std::vector<Diagnostic>> read(const std::filesystem::path& path, int threads) {
  Diagnostics diagnostics;
  ReadOptions options;
  options.threads = threads;
  std::optional<Result<MeshFile>> file;
  {
    const py::gil_scoped_release unlocked;
    file = read_mesh_file(file_name(path), options, diagnostics);
  }
  if (!*file) diagnostics.add(file->error());
  if (diagnostics.has_errors()) raise(diagnostics);
  return {Mesh{std::make_shared<const TriangleMesh>(std::move((*file)->mesh))}, diagnostics.all()};
}

void add_curve(py::module_& module) {
  py::class_<Curve>(module, "Curve", "A polyline over a mesh's vertices.")
      .def_property_readonly(
          "kind",
          [](const Curve& c) {
            constexpr std::array<const char*, 4> kWords{"crease", "edge", "jump", "other"};
            return kWords[static_cast<std::size_t>(c.curve().kind)];
          },
          "'crease' two elements meet, 'edge' the surface ends, 'jump' a side of a wall, 'other'.")
      .def_property_readonly(
          "between",
          [](const Curve& c) {
            std::vector<std::string> names;
            for (const std::uint32_t each : c.curve().between) {
              if (each < c.mesh->elements.size()) names.push_back(c.mesh->elements[each].name);
            }
            return names;
          },
          "Names of the elements on its sides.")
      .def_property_readonly(
          "vertices",
          [](const py::object& self) {
            return view(self.cast<const Curve&>().curve().vertices, self);
          },
          "Indices of vertices, uint32; a closed curve repeats none.")
      .def_property_readonly(
          "closed", [](const Curve& c) { return c.curve().closed; },
          "True where the last vertex joins the first.");
}

}  // namespace

void add_mesh(py::module_& module) {
  add_curve(module);
  py::class_<Mesh>(module, "Mesh",
                   "Triangles with named surface elements. Its arrays are read-only views.\n\n"
                   "Made of arrays: Mesh(vertices, triangles, element, names, unit, name).")
      .def(py::init(&make_mesh), py::arg("vertices"), py::arg("triangles"),
           py::arg("element") = py::none(), py::arg("names") = std::vector<std::string>{},
           py::arg("unit") = "mm", py::arg("name") = "mesh",
           "A mesh of somebody's arrays, Z up; element indexes names, one a triangle.")
      .def_property_readonly(
          "vertices", [](const py::object& self) { return view3(mesh_of(self).positions, self); },
          "Positions, float64, (n, 3).")
      .def_property_readonly(
          "triangles", [](const py::object& self) { return view3(mesh_of(self).triangles, self); },
          "Indices of vertices, uint32, (m, 3), anticlockwise seen from outside.")
      .def_property_readonly(
          "element",
          [](const py::object& self) { return view(mesh_of(self).triangle_element, self); },
          "Index into names of each triangle, uint32; empty where nothing is named.")
      .def_property_readonly(
          "names", [](const Mesh& m) { return names_of(*m.mesh); }, "Names of the elements.")
      .def_property_readonly(
          "normals", [](const py::object& self) { return view3(mesh_of(self).normals, self); },
          "Unit normals that corner_normals indexes, float64, (k, 3); may be empty.")
      .def_property_readonly(
          "corner_normals",
          [](const py::object& self) { return view3(mesh_of(self).corner_normals, self); },
          "Index into normals of each triangle's corners, uint32, (m, 3): corners of one vertex "
          "share "
          "it exactly where the surface is smooth across it.")
      .def_property_readonly(
          "curves",
          [](const Mesh& m) {
            std::vector<Curve> curves;
            for (std::size_t k = 0; k < m.mesh->curves.size(); ++k) curves.push_back({m.mesh, k});
            return curves;
          },
          "Creases, edges and sides of walls.")
      .def_property_readonly(
          "unit", [](const Mesh& m) { return std::string(name_of(m.mesh->unit)); },
          "'mm', 'cm', 'm', 'inch' or 'unknown'.")
      .def_property_readonly(
          "name", [](const Mesh& m) { return m.mesh->name; }, "Of the part program or file.")
      .def_readonly("report", &Mesh::report,
                    "The figures of diesink export --json; None where it was not tessellated.")
      .def_readonly("kept", &Mesh::kept, "True where the tolerance is certified everywhere.")
      .def("write", &write, py::arg("path"), py::kw_only(), py::arg("ascii") = false,
           py::arg("lines") = false, py::arg("draco") = false,
           "Writes a file, told by its ending, whole or not at all. Gives what the format says of "
           "it.")
      .def("__repr__", [](const Mesh& m) {
        return "<diesink.Mesh " + m.mesh->name + ": " + std::to_string(m.mesh->triangles.size()) +
               " triangles, " + std::to_string(m.mesh->positions.size()) + " vertices, " +
               std::to_string(m.mesh->elements.size()) + " elements>";
      });
  module.def(
      "read_mesh", &read, py::arg("path"), py::arg("threads") = 0,
      "Reads STL, OBJ, PLY, OFF, glTF or GLB, told by its content: the mesh and the warnings.");
}

}  // namespace diesink::python
