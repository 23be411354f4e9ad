#include "tools/experiment/csv.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

using nlohmann::ordered_json;
using tactus::experiment::csv_of;
using tactus::experiment::CsvColumn;

TEST_CASE("A CSV has the columns' headings, and of each row what their keys say, in their order") {
  constexpr CsvColumn kColumns[] = {
      {"time [s]", "time_s"}, {"name", "name", CsvColumn::Cell::kQuoted}, {"second", "list/1"}};
  const ordered_json rows = {{{"name", "a, b"}, {"time_s", 0.1}, {"list", {1, -2}}},
                             {{"name", ""}, {"time_s", nullptr}, {"list", {true, false}}}};
  CHECK(csv_of(kColumns, rows) == "time [s],name,second\n0.1,\"a, b\",-2\n,\"\",false\n");
}

TEST_CASE("A number in a CSV is as short as it is exact, and whole or 1 for true where the column says so") {
  constexpr CsvColumn kColumns[] = {
      {"x", "x"}, {"n", "n", CsvColumn::Cell::kWhole}, {"yes", "yes", CsvColumn::Cell::kOneOrZero}};
  const double x = 1.0 / 3;
  const std::string text = csv_of(kColumns, ordered_json::array({{{"x", x}, {"n", 1234.6}, {"yes", true}}}));
  CHECK(text == "x,n,yes\n0.3333333333333333,1235,1\n");
  CHECK(csv_of(kColumns, ordered_json::array()) == "x,n,yes\n");
}
