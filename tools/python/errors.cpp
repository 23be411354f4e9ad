#include "tools/python/errors.h"

#include <algorithm>
#include <array>

namespace py = pybind11;

namespace tactus::python {
namespace {

struct Exception {
  const char* name;
  PyObject** base;  // of Python, beside tactus.Error
  const char* meaning;
  PyObject* type;
};

PyObject* g_error{nullptr};
// By Error::Kind, from kFile on.
std::array<Exception, 4> g_exceptions{{
    {"FileError", &PyExc_ValueError, "A scene or a tape has mistakes; a line for each.", nullptr},
    {"OptionError", &PyExc_ValueError, "An option, or a value that was given, is not accepted.", nullptr},
    {"MachineError", &PyExc_OSError, "The machine lacks something or reports an error.", nullptr},
    {"UseError", &PyExc_RuntimeError, "A call that is not allowed now.", nullptr},
}};

}  // namespace

void add_errors(py::module_& module) {
  g_error = PyErr_NewExceptionWithDoc("tactus.Error", "What tactus has to say against a call; below it are all others.",
                                      nullptr, nullptr);
  module.attr("Error") = py::handle(g_error);
  for (Exception& exception : g_exceptions) {
    const py::tuple bases = py::make_tuple(py::handle(g_error), py::handle(*exception.base));
    const std::string name = std::string("tactus.") + exception.name;
    exception.type = PyErr_NewExceptionWithDoc(name.c_str(), exception.meaning, bases.ptr(), nullptr);
    module.attr(exception.name) = py::handle(exception.type);
  }
}

void raise(Error::Kind kind, const std::string& message) {
  const auto index = static_cast<std::size_t>(kind) - static_cast<std::size_t>(Error::Kind::kFile);
  PyErr_SetString(g_exceptions.at(index).type, message.c_str());
  throw py::error_already_set();
}

std::string shown(const py::handle& value) {
  constexpr std::size_t kLongest = 64;
  std::string text = py::cast<std::string>(py::repr(value));
  std::ranges::replace_if(
      text, [](char c) { return static_cast<unsigned char>(c) < ' '; }, ' ');
  if (text.size() > kLongest) text = text.substr(0, kLongest - 3) + "...";
  return text;
}

void raise_if(const Error& error) {
  if (error) raise(error.kind(), error.message());
}

}  // namespace tactus::python
