#include "tools/python/columns.h"

#include <fmt/format.h>

#include <algorithm>

#include "rt/text/nearest_word.h"
#include "tools/python/layouts.h"

namespace py = pybind11;

namespace tactus::python {

using exporting::Column;
using exporting::ColumnType;
using exporting::Row;

namespace {

py::dtype type_of(const Column& column) {
  if (column.type == ColumnType::kReal) return py::dtype::of<double>();
  return column.type == ColumnType::kCount ? py::dtype::of<std::uint64_t>() : py::dtype::of<std::uint32_t>();
}

}  // namespace

std::vector<std::string> column_names() {
  std::vector<std::string> names;
  for (const Column& column : exporting::all_columns()) names.push_back(column.name);
  return names;
}

const Column& column_named(const std::string& name) {
  const auto& columns = exporting::all_columns();
  const auto column = std::ranges::find(columns, name, &Column::name);
  if (column != columns.end()) return *column;
  const auto known = column_names();
  const std::vector<std::string_view> views(known.begin(), known.end());
  const auto nearest = text::nearest_word(name, views);
  throw py::key_error(fmt::format("'{:.64}' is no column{}; accepted: those of Tape.columns", name,
                                  nearest.empty() ? "" : fmt::format(", did you mean {}?", nearest)));
}

py::dict about(const Column& column) {
  py::dict texts;
  texts["unit"] = column.unit;
  texts["frame"] = column.frame;
  texts["group"] = column.group;
  texts["meaning"] = column.meaning;
  return texts;
}

py::array column_of(std::span<const Row> rows, const Column& column, double period_s, const py::handle& owner) {
  const auto count = static_cast<py::ssize_t>(rows.size());
  if (column.type == ColumnType::kTime) {
    py::array_t<double> times(count);
    std::ranges::transform(rows, times.mutable_data(),
                           [&](const Row& row) { return exporting::time_of(row.tick.out.tick, period_s); });
    return times;
  }
  const void* first = rows.empty() ? nullptr : reinterpret_cast<const std::byte*>(rows.data()) + column.offset;
  return view_of(type_of(column), {count}, {static_cast<py::ssize_t>(sizeof(Row))}, first, owner);
}

}  // namespace tactus::python
