#include "rt/loop/calibration.h"

#include <catch2/catch.hpp>
#include <cmath>

using namespace tactus::loop;

// What a core takes is for a benchmark to say: here only that the scale can be used, and is used for the whole table.
TEST_CASE("a calibration scales every cost by one factor within its bounds") {
  const CostModel table;
  const Calibration found = calibrate(table);
  CHECK(std::isfinite(found.scale));
  CHECK(found.scale >= 0.125);
  CHECK(found.scale <= 64);
  CHECK(std::isfinite(found.spread));
  CHECK(found.spread >= 1);
  CHECK(found.cost.fixed == table.fixed * found.scale);
  CHECK(found.cost.per_body == table.per_body * found.scale);
  CHECK(found.cost.per_pair == table.per_pair * found.scale);
  CHECK(found.cost.per_contact == table.per_contact * found.scale);
  CHECK(found.cost.per_point_sub_step == table.per_point_sub_step * found.scale);
  CHECK(found.cost.per_body_sub_step == table.per_body_sub_step * found.scale);
  CHECK(found.cost.per_border_sub_step == table.per_border_sub_step * found.scale);
  CHECK(found.cost.synchronisation == table.synchronisation * found.scale);
  CHECK(found.cost.per_join == table.per_join * found.scale);
}

TEST_CASE("a table that no machine can match is scaled as far as the bounds") {
  CostModel table;
  for (double* cost : {&table.fixed, &table.per_body, &table.per_pair, &table.per_contact, &table.per_point_sub_step,
                       &table.per_body_sub_step, &table.per_border_sub_step})
    *cost *= 1e9;
  CHECK(calibrate(table).scale == 0.125);
  for (double* cost : {&table.fixed, &table.per_body, &table.per_pair, &table.per_contact, &table.per_point_sub_step,
                       &table.per_body_sub_step, &table.per_border_sub_step})
    *cost *= 1e-18;
  CHECK(calibrate(table).scale == 64);
}
