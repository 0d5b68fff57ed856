// CC-data over arrays of plan points and over grids.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/grid/grid_array.h"
#include "core/parallel.h"
#include "python/arrays.h"
#include "python/bindings.h"

namespace diesink::python {
namespace {

constexpr std::size_t kPointsABlock = 1024;

using Shape = std::vector<py::ssize_t>;

// New arrays of a shape, to be filled without the interpreter's lock.
struct Filling {
  py::array_t<double> z, normals;
  py::array_t<std::int32_t> surface, row, face, element;
  double* to_z;
  double* to_normals;
  std::int32_t *to_surface, *to_row, *to_face, *to_element;

  explicit Filling(const Shape& shape)
      : z(shape),
        normals(with_three(shape)),
        surface(shape),
        row(shape),
        face(shape),
        element(shape),
        to_z(z.mutable_data()),
        to_normals(normals.mutable_data()),
        to_surface(surface.mutable_data()),
        to_row(row.mutable_data()),
        to_face(face.mutable_data()),
        to_element(element.mutable_data()) {}

  static Shape with_three(Shape shape) {
    shape.push_back(3);
    return shape;
  }

  void put(std::size_t k, const CompoundSurface& of, Label label, double height, const Vec3& n) {
    const bool none = label == kNoLabel;
    to_z[k] = none ? std::numeric_limits<double>::quiet_NaN() : height;
    for (int axis = 0; axis < 3; ++axis) {
      to_normals[3 * k + static_cast<std::size_t>(axis)] = none ? 0 : n[axis];
    }
    to_row[k] = none ? -1 : row_of(label);
    to_face[k] = none ? -1 : face_of(label);
    to_surface[k] = none ? -1 : of.surface_of_row(row_of(label));
  }

  // Names of the labels that occur, ascending, and each point's index among them.
  std::vector<std::string> number_elements(const CompoundSurface& of) {
    const auto count = static_cast<std::size_t>(z.size());
    // Face numbers take four bits.
    std::vector<std::int32_t> index(static_cast<std::size_t>(of.row_count()) << 4, -1);
    const auto slot = [&](std::size_t k) {
      return make_label(to_row[k], static_cast<std::uint32_t>(to_face[k]));
    };
    for (std::size_t k = 0; k < count; ++k) {
      if (to_row[k] >= 0) index[slot(k)] = 0;
    }
    // A solid that stands in several terms keeps one name.
    std::vector<std::string> names;
    for (std::size_t label = 0; label < index.size(); ++label) {
      if (index[label] < 0) continue;
      const std::string name = of.element_name(static_cast<Label>(label));
      auto known = std::find(names.begin(), names.end(), name);
      if (known == names.end()) known = names.insert(known, name);
      index[label] = static_cast<std::int32_t>(known - names.begin());
    }
    for (std::size_t k = 0; k < count; ++k) {
      to_element[k] = to_row[k] >= 0 ? index[slot(k)] : -1;
    }
    return names;
  }
};

CcArrays finished(py::array x, py::array y, Filling& filling,
                  const std::vector<std::string>& names) {
  CcArrays data;
  data.x = std::move(x);
  data.y = std::move(y);
  data.z = filling.z;
  data.normals = filling.normals;
  data.surface = filling.surface;
  data.row = filling.row;
  data.face = filling.face;
  data.element = filling.element;
  for (const std::string& name : names) data.names.append(name);
  return data;
}

// Finite numbers, ascending; what else there is raises.
std::vector<double> lines_of(const char* name, const py::object& given) {
  const Given<double> array = Given<double>::ensure(given);
  if (!array) raise_usage(std::string(name) + " needs numbers");
  if (array.ndim() != 1 || array.size() == 0) {
    raise_usage(std::string(name) + " needs one axis with at least one number");
  }
  std::vector<double> lines(array.data(), array.data() + array.size());
  for (std::size_t k = 0; k < lines.size(); ++k) {
    if (!std::isfinite(lines[k]) || (k > 0 && lines[k] <= lines[k - 1])) {
      raise_usage(std::string(name) + " needs finite numbers that ascend (not so at index " +
                  std::to_string(k) + ")");
    }
  }
  return lines;
}

}  // namespace

CcArrays evaluate(const Part& part, const py::object& x, const py::object& y, int threads) {
  const py::object numpy = py::module_::import("numpy");
  const py::sequence both = numpy.attr("broadcast_arrays")(x, y);
  const Given<double> xs = Given<double>::ensure(both[0]), ys = Given<double>::ensure(both[1]);
  if (!xs || !ys) raise_usage("x and y need numbers");
  const Shape shape(xs.shape(), xs.shape() + xs.ndim());
  Filling filling(shape);
  const double *px = xs.data(), *py = ys.data();
  const auto count = static_cast<std::size_t>(xs.size());
  std::vector<std::string> names;
  {
    const pybind11::gil_scoped_release unlocked;
    parallel_blocks(count, kPointsABlock, threads, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t k = begin; k < end; ++k) {
        // What is no place has no surface.
        const std::optional<CcDatum> datum = std::isfinite(px[k]) && std::isfinite(py[k])
                                                 ? part.surface.at(px[k], py[k])
                                                 : std::nullopt;
        const Label label =
            datum ? make_label(datum->row, static_cast<std::uint32_t>(datum->face)) : kNoLabel;
        filling.put(k, part.surface, label, datum ? datum->z : 0, datum ? datum->n : Vec3::Zero());
      }
    });
    names = filling.number_elements(part.surface);
  }
  return finished(xs, ys, filling, names);
}

CcArrays evaluate_lines(const Part& part, const py::object& x, const py::object& y, int threads) {
  const Machining& m = part.surface.program().machining;
  std::vector<double> xs =
      x.is_none() ? grid_lines(m.x_range[0], m.x_range[1], m.x_interval) : lines_of("x", x);
  std::vector<double> ys =
      y.is_none() ? grid_lines(m.y_range[0], m.y_range[1], m.y_interval) : lines_of("y", y);
  const py::array_t<double> keep_x(static_cast<py::ssize_t>(xs.size()), xs.data());
  const py::array_t<double> keep_y(static_cast<py::ssize_t>(ys.size()), ys.data());
  std::optional<Result<GridArray>> grid;
  {
    const py::gil_scoped_release unlocked;
    grid = evaluate_grid(part.surface, std::move(xs), std::move(ys), threads);
  }
  const GridArray done = value_or_raise(std::move(*grid));
  Filling filling({keep_y.size(), keep_x.size()});
  std::vector<std::string> names;
  {
    const py::gil_scoped_release unlocked;
    parallel_blocks(done.size(), kPointsABlock, threads,
                    [&](std::size_t begin, std::size_t end, int) {
                      for (std::size_t k = begin; k < end; ++k) {
                        filling.put(k, part.surface, done.label()[k], done.z()[k],
                                    {done.nx()[k], done.ny()[k], done.nz()[k]});
                      }
                    });
    names = filling.number_elements(part.surface);
  }
  return finished(keep_x, keep_y, filling, names);
}

void add_cc_data(py::module_& module) {
  py::class_<CcArrays>(module, "CcData",
                       "CC-data over plan points: what a vertical line meets there.\n\n"
                       "Where there is no surface z is NaN, the normal 0 and every number -1.")
      .def_readonly("x", &CcArrays::x, "Plan points, or the grid's lines along y.")
      .def_readonly("y", &CcArrays::y, "Plan points, or the grid's lines along x.")
      .def_readonly("z", &CcArrays::z, "Heights, float64.")
      .def_readonly("normals", &CcArrays::normals,
                    "Unit normals, upward: the shape of z and a last axis of 3.")
      .def_readonly("surface", &CcArrays::surface, "0 the base, k the k-th solid; int32.")
      .def_readonly("row", &CcArrays::row, "Row of the Boolean table, from 0; int32.")
      .def_readonly("face", &CcArrays::face, "Number of the face, 0 for the base; int32.")
      .def_readonly("element", &CcArrays::element, "Index into names; int32.")
      .def_readonly("names", &CcArrays::names, "Surface elements that occur: 'S2.side', 'B'.")
      .def("__repr__", [](const CcArrays& data) {
        return "<diesink.CcData " + std::string(py::str(data.z.attr("shape"))) + ", " +
               std::to_string(data.names.size()) + " elements>";
      });
}

}  // namespace diesink::python
