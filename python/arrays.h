// Between vectors of the library and numpy's arrays.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/numpy.h>

#include <vector>

#include "core/vec.h"

namespace diesink::python {

namespace py = pybind11;

// A read-only view of memory that `owner` keeps alive.
template <class T>
py::array view(const T* data, std::vector<py::ssize_t> shape, std::vector<py::ssize_t> strides,
               const py::handle& owner) {
  py::array array(py::dtype::of<T>(), std::move(shape), std::move(strides), data, owner);
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

template <class T>
py::array view(const std::vector<T>& values, const py::handle& owner) {
  return view(values.data(), {static_cast<py::ssize_t>(values.size())}, {sizeof(T)}, owner);
}

// Rows of three.
template <class T>
py::array view3(const std::vector<std::array<T, 3>>& rows, const py::handle& owner) {
  return view(reinterpret_cast<const T*>(rows.data()), {static_cast<py::ssize_t>(rows.size()), 3},
              {3 * sizeof(T), sizeof(T)}, owner);
}
inline py::array view3(const std::vector<Vec3>& rows, const py::handle& owner) {
  static_assert(sizeof(Vec3) == 3 * sizeof(double));
  return view(reinterpret_cast<const double*>(rows.data()),
              {static_cast<py::ssize_t>(rows.size()), 3}, {3 * sizeof(double), sizeof(double)},
              owner);
}

// What somebody gives: any sequence or array, copied only where it must be.
template <class T>
using Given = py::array_t<T, py::array::c_style | py::array::forcecast>;

}  // namespace diesink::python
