// The extension module tactus._core: what of the Python module is C++. tactus/*.py are around it.
#include <pybind11/pybind11.h>

#include "tools/python/classes.h"
#include "tools/python/errors.h"
#include "tools/version/version.h"

PYBIND11_MODULE(_core, module) {
  module.doc() = "The part of the module tactus that is C++.";
  module.attr("__version__") = tactus::version();
  tactus::python::add_errors(module);
  tactus::python::add_scene(module);
  tactus::python::add_session(module);
  tactus::python::add_tape(module);
  tactus::python::add_live(module);
}
