#include "tools/python/errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>

namespace py = pybind11;

namespace tactus::python {
namespace {

struct Exception {
  const char* name;
  PyObject** base;  // second base class, of Python
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
  // Bytes that are not UTF-8, as in a file's name, are shown as \xNN.
  PyObject* const text =
      PyUnicode_DecodeUTF8(message.data(), static_cast<Py_ssize_t>(message.size()), "backslashreplace");
  if (text == nullptr) throw py::error_already_set();
  PyErr_SetObject(g_exceptions.at(index).type, text);
  Py_DECREF(text);
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

std::filesystem::path path_of(const py::handle& value, const char* call) {
  PyObject* bytes = nullptr;
  if (PyUnicode_FSConverter(value.ptr(), &bytes) == 0) {
    PyErr_Clear();
    raise(Error::Kind::kOption,
          fmt::format("{}: {} is no path; accepted: text or a path, without NUL", call, shown(value)));
  }
  return std::string(py::reinterpret_steal<py::bytes>(bytes));
}

void* ZeroedByPython::operator new(std::size_t bytes) {
  void* const memory = ::operator new(bytes);
  std::memset(memory, 0, bytes);
  return memory;
}

void ZeroedByPython::operator delete(void* memory) noexcept { ::operator delete(memory); }

void ZeroedByPython::made(const char* name) const {
  if (mark_ != kMade)
    raise(Error::Kind::kUse, fmt::format("{}: it has no content; accepted: one that {}(...) made", name, name));
}

void raise_if(const Error& error) {
  if (error) raise(error.kind(), error.message());
}

}  // namespace tactus::python
