// The classes of the Python module, one file each. Thread: with the GIL held.
#pragma once

#include <pybind11/pybind11.h>

namespace tactus::python {

void add_scene(pybind11::module_& module);
void add_session(pybind11::module_& module);
void add_tape(pybind11::module_& module);
void add_live(pybind11::module_& module);

}  // namespace tactus::python
