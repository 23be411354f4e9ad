#include "tools/export/columns.h"

#include <catch2/catch.hpp>
#include <cstring>
#include <set>

using namespace tactus;
using namespace tactus::exporting;

namespace {

std::size_t bytes_of(const Column& column) {
  switch (column.type) {
    case ColumnType::kReal:
    case ColumnType::kCount:
      return 8;
    case ColumnType::kNumber:
      return 4;
    case ColumnType::kTime:
      break;
  }
  return 0;
}

const Column& named(const std::string& name) {
  for (const Column& column : all_columns())
    if (column.name == name) return column;
  FAIL("no column " << name);
  return all_columns().front();
}

std::vector<std::string> names_of(const std::vector<Column>& columns) {
  std::vector<std::string> names;
  for (const Column& column : columns) names.push_back(column.name);
  return names;
}

}  // namespace

TEST_CASE("the columns cover every byte of a tick's records once, padding excepted") {
  std::vector<int> covered(sizeof(Row), 0);
  for (const Column& column : all_columns())
    for (std::size_t i = 0; i < bytes_of(column); ++i) ++covered.at(column.offset + i);
  for (std::size_t i = 0; i < sizeof(Row::times.tick); ++i) ++covered.at(offsetof(Row, times.tick) + i);  // the tick's
  for (const std::size_t padding : {offsetof(Row, tick.device.padding), offsetof(Row, tick.device.sample.padding)})
    for (std::size_t i = 0; i < 4; ++i) {
      CHECK(covered[padding + i] == 0);
      covered[padding + i] = 1;
    }
  for (std::size_t i = 0; i < covered.size(); ++i) {
    INFO("byte " << i);
    CHECK(covered[i] == 1);
  }
}

TEST_CASE("a column's value is the record's, and its time the end of the tick") {
  Row row;
  loop::TickRecord& tick = row.tick;
  row.times.compute_ns = 12'345;
  row.times.woke_ns = 1'000'000'007;
  tick.device.sample.device_from_tool.position.y = 0.1;
  tick.device.sample.buttons = 5;
  tick.sub_steps = 4;
  tick.out.tick = 1999;
  tick.out.command.wrench.force = {1.25, -2.5, 3e-300};
  tick.out.proxy.pose.rotation.w = -0.5;
  tick.out.fault = Fault::kWorldLost;
  tick.out.device_energy_J = 7;
  CHECK(value_of(named("tool_position_y_m"), row, 1e-3).real == 0.1);
  CHECK(value_of(named("buttons"), row, 1e-3).count == 5);
  CHECK(value_of(named("sub_steps"), row, 1e-3).count == 4);
  CHECK(value_of(named("tick"), row, 1e-3).count == 1999);
  CHECK(value_of(named("time_s"), row, 1e-3).real == 2000 * 1e-3);
  CHECK(value_of(named("force_y_N"), row, 1e-3).real == -2.5);
  CHECK(value_of(named("force_z_N"), row, 1e-3).real == 3e-300);
  CHECK(value_of(named("proxy_rotation_w"), row, 1e-3).real == -0.5);
  CHECK(value_of(named("fault"), row, 1e-3).count == static_cast<std::uint64_t>(Fault::kWorldLost));
  CHECK(value_of(named("compute_ns"), row, 1e-3).count == 12'345);
  CHECK(value_of(named("woke_ns"), row, 1e-3).count == 1'000'000'007);
  CHECK(value_of(named("device_energy_J"), row, 1e-3).real == 7);
}

TEST_CASE("names are unique, and a column of a quantity ends with its unit") {
  std::set<std::string> names;
  for (const Column& column : all_columns()) {
    INFO(column.name);
    CHECK(names.insert(column.name).second);
    CHECK_FALSE(column.meaning.empty());
    const bool pure = column.unit.empty() || column.unit == "1";
    std::string suffix = column.unit == "N m" ? "Nm" : column.unit;
    if (const auto slash = suffix.find('/'); slash != std::string::npos) suffix.replace(slash, 1, "_per_");
    CHECK((pure || column.name.ends_with("_" + suffix)));
    CHECK((column.is_real() ? !column.unit.empty() : true));
  }
}

TEST_CASE("signals are columns or groups, in the table's order, with tick and time, and all without any") {
  const std::vector<std::string> none, some{"members", "force"}, bad{"force", "membres"};
  CHECK(select_columns(none).value().size() == all_columns().size());
  const auto chosen = select_columns(some);
  REQUIRE(chosen.ok());
  CHECK(names_of(chosen.value()) ==
        std::vector<std::string>{"tick", "time_s", "force_x_N", "force_y_N", "force_z_N", "members"});
  const auto refused = select_columns(bad);
  REQUIRE_FALSE(refused.ok());
  CHECK_THAT(refused.message(), Catch::Contains("'membres' is no signal, did you mean members?; accepted: "));
}
