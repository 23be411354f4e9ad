// The exceptions of the Python module: tactus.Error and below it FileError, OptionError, MachineError, UseError, by the
// kind of the library's Error. Thread: with the GIL held.
#pragma once

#include <pybind11/pybind11.h>

#include <string>

#include "rt/base/result.h"
#include "tactus/error.h"

namespace tactus::python {

void add_errors(pybind11::module_& module);

[[noreturn]] void raise(Error::Kind kind, const std::string& message);
// A value for a message: its repr, short and in one line.
std::string shown(const pybind11::handle& value);
// Nothing on success.
void raise_if(const Error& error);

}  // namespace tactus::python
