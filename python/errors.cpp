// diesink.Error and the diagnostics it carries.
// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "core/number.h"
#include "python/bindings.h"

namespace diesink::python {
namespace {

constexpr double kLargestNumber = 1e9;  // as in part programs

// Set once when the module is loaded, and kept as long as the interpreter runs.
PyObject* error_class = nullptr;

const char* name_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::kUsage:
      return "usage";
    case ErrorCode::kUnsupported:
      return "unsupported";
    case ErrorCode::kOutput:
      return "output";
    case ErrorCode::kLimit:
      return "limit";
    case ErrorCode::kInput:
      break;
  }
  return "input";
}

constexpr const char* kErrorText =
    "What is wrong with a file or an argument.\n\n"
    "str() gives the messages with their places, one a line; `diagnostics` is the tuple of them, "
    "the "
    "warnings that came before among them; `code` is the first error's: 'input', 'usage', 'limit', "
    "'unsupported' or 'output'.";

py::object optional_number(std::uint32_t value) {
  return value > 0 ? py::object(py::int_(value)) : py::object(py::none());
}

}  // namespace

void raise(const Diagnostics& diagnostics) {
  py::list all;
  std::string text;
  const char* code = nullptr;
  for (const Diagnostic& each : diagnostics.all()) {
    all.append(py::cast(each));
    if (each.severity != Severity::kError) continue;
    if (code == nullptr) code = name_of(each.code);
    text += (text.empty() ? "" : "\n") + to_text(each);
  }
  const py::handle type(error_class);
  const py::object error = type(text);
  error.attr("diagnostics") = py::tuple(all);
  error.attr("code") = code == nullptr ? "input" : code;
  PyErr_SetObject(error_class, error.ptr());
  throw py::error_already_set();
}

void raise(const Error& error) {
  Diagnostics diagnostics;
  diagnostics.add(error);
  raise(diagnostics);
}

void raise_usage(std::string message) {
  raise(Error{ErrorCode::kUsage, std::move(message), {"diesink", 0, 0, -1}});
}

void check_positive(const char* name, const std::optional<double>& value) {
  if (!value || (*value > 0 && *value <= kLargestNumber)) return;
  raise_usage(std::string(name) + " needs a number above 0 and at most 1e9 (got " +
              number_text(*value) + ")");
}

void check_not_negative(const char* name, const std::optional<double>& value) {
  if (!value || (*value >= 0 && *value <= kLargestNumber)) return;
  raise_usage(std::string(name) + " needs a number from 0 to 1e9 (got " + number_text(*value) +
              ")");
}

void check_number(const char* name, const std::optional<double>& value) {
  if (!value || std::fabs(*value) <= kLargestNumber) return;
  raise_usage(std::string(name) + " needs a number from -1e9 to 1e9 (got " + number_text(*value) +
              ")");
}

std::string file_name(const std::filesystem::path& path) {
  return path == "-" ? "./-" : path.string();
}

py::object from_json(const std::string& text) {
  return py::module_::import("json").attr("loads")(text);
}

void add_errors(py::module_& module) {
  error_class = PyErr_NewExceptionWithDoc("diesink.Error", kErrorText, PyExc_ValueError, nullptr);
  if (error_class == nullptr) throw py::error_already_set();
  module.attr("Error") = py::handle(error_class);

  py::class_<Diagnostic>(module, "Diagnostic",
                         "One message: what was found, what was expected, and where.")
      .def_property_readonly(
          "severity",
          [](const Diagnostic& d) { return d.severity == Severity::kError ? "error" : "warning"; },
          "'error' or 'warning'.")
      .def_property_readonly(
          "code", [](const Diagnostic& d) { return name_of(d.code); },
          "'input', 'usage', 'limit', 'unsupported' or 'output'; of an error.")
      .def_readonly("message", &Diagnostic::message, "The sentence, without the place.")
      .def_property_readonly(
          "file", [](const Diagnostic& d) { return d.where.file; }, "Name of the file.")
      .def_property_readonly(
          "line", [](const Diagnostic& d) { return optional_number(d.where.line); },
          "Line, from 1; None where there is none.")
      .def_property_readonly(
          "column", [](const Diagnostic& d) { return optional_number(d.where.column); },
          "Byte of the line, from 1; None where there is none.")
      .def_property_readonly(
          "byte",
          [](const Diagnostic& d) {
            return d.where.byte >= 0 ? py::object(py::int_(d.where.byte)) : py::object(py::none());
          },
          "Offset in a binary file; None where there is none.")
      .def_readonly("source_line", &Diagnostic::source_line, "The line's text; may be empty.")
      .def("__str__", [](const Diagnostic& d) { return to_text(d); })
      .def("__repr__", [](const Diagnostic& d) {
        Diagnostic one_line = d;
        one_line.source_line.clear();
        return "<diesink.Diagnostic " + to_text(one_line) + ">";
      });
}

}  // namespace diesink::python
