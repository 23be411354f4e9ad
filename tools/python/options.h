// Keyword arguments of Python as the library's Options. Thread: with the GIL held.
#pragma once

#include <pybind11/pybind11.h>

#include "tactus/options.h"

namespace tactus::python {

// Raises OptionError: no such option, with the nearest one; a value of another type. Ranges are checked by the library.
Options options_of(const pybind11::dict& given);

}  // namespace tactus::python
