// A CSV file of an experiment: the columns, and where in a row of the JSON each value is. So a value and what it is
// computed from stand in one place, the row's JSON; the CSV only names and orders.
// Thread: any normal one. Bound: the rows.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

namespace tactus::experiment {

struct CsvColumn {
  enum class Cell {
    kPlain,     // numbers as short as they are exact, true or false, text; null: empty
    kQuoted,    // text in quotes
    kWhole,     // a number without decimals
    kOneOrZero  // true: 1
  };

  const char* heading;  // with unit: "median [us]"
  const char* key;      // of the value in the row; KEY/2: the third of an array
  Cell cell{Cell::kPlain};
};

// The heading, and a line for each of the rows, an array of objects. Each row has every key.
std::string csv_of(std::span<const CsvColumn> columns, const nlohmann::ordered_json& rows);

}  // namespace tactus::experiment
