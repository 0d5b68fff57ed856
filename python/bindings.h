// The classes of the Python module and what its files share.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/compound/compound_surface.h"
#include "core/diagnostics.h"
#include "core/machining/verify.h"
#include "core/mesh.h"
#include "core/tool_path.h"

namespace diesink::python {

namespace py = pybind11;

// Raises diesink.Error.
// Needs: the interpreter's lock.
[[noreturn]] void raise(const Diagnostics& diagnostics);
[[noreturn]] void raise(const Error& error);
// The same with kUsage, for a wrong argument.
[[noreturn]] void raise_usage(std::string message);

template <class T>
T value_or_raise(Result<T> result) {
  if (!result) raise(result.error());
  return std::move(*result);
}
inline void check(const Status& status) {
  if (!status) raise(status.error());
}

// Raises unless `value`, where there is one, is a number above 0 and at most 1e9.
void check_positive(const char* name, const std::optional<double>& value);
// The same for one from 0 on, and for one of either sign.
void check_not_negative(const char* name, const std::optional<double>& value);
void check_number(const char* name, const std::optional<double>& value);

// A file name for formats/, where "-" alone would mean stdin or stdout.
std::string file_name(const std::filesystem::path& path);

// The value of a JSON text as Python's own.
py::object from_json(const std::string& text);

// One of `words`, whose index is that of the enumeration's value; raises where it is none.
template <class Enumeration>
Enumeration word_of(const char* name, const std::string& word,
                    std::initializer_list<const char*> words) {
  int index = 0;
  std::string known;
  for (const char* each : words) {
    if (word == each) return static_cast<Enumeration>(index);
    known += (index++ > 0 ? ", '" : "'") + std::string(each) + "'";
  }
  raise_usage(std::string(name) + ": '" + word + "' is none of " + known);
}

// A part program and its surface; they do not change, so that any thread may ask.
struct Part {
  CompoundSurface surface;
  std::vector<Diagnostic> warnings;
};

// CC-data over plan points, as arrays of one shape; no surface is NaN, normal 0 and -1.
struct CcArrays {
  py::array x, y, z, normals, surface, row, face, element;
  py::list names;
};

struct Mesh {
  std::shared_ptr<const TriangleMesh> mesh;
  py::object report = py::none();  // of a tessellation
  bool kept = true;
};

struct Path {
  std::shared_ptr<const ToolPath> path;
  py::object report = py::none();  // of a plan
  bool kept = true;
  py::list contacts = py::list();  // of method cc: points and normals of each pass
};

struct Check {
  std::shared_ptr<const VerifyReport> found;
  py::object report;
  bool kept = true;
};

CcArrays evaluate(const Part& part, const py::object& x, const py::object& y, int threads);
CcArrays evaluate_lines(const Part& part, const py::object& x, const py::object& y, int threads);

// Each adds its classes and functions to the module.
void add_errors(py::module_& module);
void add_cc_data(py::module_& module);
void add_mesh(py::module_& module);
void add_tool_path(py::module_& module);
void add_part(py::module_& module);

}  // namespace diesink::python
