#include "tools/experiment/csv.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace tactus::experiment {
namespace {

using nlohmann::ordered_json;

std::string text_of(const ordered_json& value, CsvColumn::Cell cell) {
  if (value.is_null()) return "";
  if (cell == CsvColumn::Cell::kQuoted) return fmt::format("\"{}\"", value.get<std::string>());
  if (cell == CsvColumn::Cell::kWhole) return fmt::format("{:.0f}", value.get<double>());
  if (cell == CsvColumn::Cell::kOneOrZero) return value.get<bool>() ? "1" : "0";
  if (value.is_string()) return value.get<std::string>();
  if (value.is_boolean()) return fmt::format("{}", value.get<bool>());
  if (value.is_number_unsigned()) return fmt::format("{}", value.get<std::uint64_t>());
  if (value.is_number_integer()) return fmt::format("{}", value.get<std::int64_t>());
  return fmt::format("{}", value.get<double>());
}

}  // namespace

std::string csv_of(std::span<const CsvColumn> columns, const ordered_json& rows) {
  std::string text;
  for (const CsvColumn& column : columns) text += fmt::format("{},", column.heading);
  text.back() = '\n';
  for (const ordered_json& row : rows) {
    for (const CsvColumn& column : columns)
      text += text_of(row.at(ordered_json::json_pointer(fmt::format("/{}", column.key))), column.cell) + ',';
    text.back() = '\n';
  }
  return text;
}

}  // namespace tactus::experiment
