// The Python module diesink._diesink: classes, functions and their docstrings.
// SPDX-License-Identifier: Apache-2.0
#include "formats/format.h"
#include "python/bindings.h"

namespace diesink::python {
namespace {

py::list formats() {
  py::list list;
  for (const Format* format : all_formats()) {
    py::dict row;
    py::list endings;
    for (const std::string_view each : format->extensions)
      endings.append(py::str(each.data(), each.size()));
    row["id"] = py::str(format->id.data(), format->id.size());
    row["title"] = py::str(format->title.data(), format->title.size());
    row["endings"] = endings;
    row["read"] = format->read != nullptr;
    row["written"] = format->write != nullptr;
    list.append(row);
  }
  return list;
}

}  // namespace
}  // namespace diesink::python

PYBIND11_MODULE(_diesink, module) {
  module.doc() = "Compound surfaces for dies. See the package diesink.";
  module.attr("__version__") = DIESINK_VERSION;
  diesink::python::add_errors(module);
  diesink::python::add_cc_data(module);
  diesink::python::add_mesh(module);
  diesink::python::add_tool_path(module);
  diesink::python::add_part(module);
  module.def("formats", &diesink::python::formats,
             "The mesh formats: a dict each with id, title, endings, read, written.");
}
