// The columns of `tactus export` as NumPy has them: views of rows in memory. Thread: with the GIL held.
#pragma once

#include <pybind11/numpy.h>

#include <span>
#include <string>
#include <vector>

#include "tools/export/columns.h"

namespace tactus::python {

std::vector<std::string> column_names();
// KeyError: there is none.
const exporting::Column& column_named(const std::string& name);
// Unit, frame, group, meaning.
pybind11::dict about(const exporting::Column& column);
// (rows,), read-only, without a copy of the rows, which `owner` keeps; but the times, which no row has. `period_s`: of
// a tick.
pybind11::array column_of(std::span<const exporting::Row> rows, const exporting::Column& column, double period_s,
                          const pybind11::handle& owner);

}  // namespace tactus::python
