// The columns of `tactus export` as NumPy has them: views of rows in memory. Thread: with the GIL held.
#pragma once

#include <pybind11/numpy.h>

#include <span>
#include <string>
#include <vector>

#include "tools/export/columns.h"

namespace tactus::python {

std::vector<std::string> column_names();
// Raises KeyError for an unknown name.
const exporting::Column& column_named(const std::string& name);
// Unit, frame, group, meaning.
pybind11::dict about(const exporting::Column& column);
// Shape (rows,), read-only: a view of the rows, which `owner` keeps alive. A column of times is a copy, since no row
// contains it. `period_s`: of a tick.
pybind11::array column_of(std::span<const exporting::Row> rows, const exporting::Column& column, double period_s,
                          const pybind11::handle& owner);

}  // namespace tactus::python
