#include "firmware/fault_log.h"

#include <catch2/catch.hpp>

using namespace tactus::firmware;

TEST_CASE("the log keeps the last sixteen faults, newest first, and counts all") {
  FaultLog log;
  CHECK(log.size() == 0);
  CHECK(log.entry(0).fault == Fault::kNone);
  for (unsigned n = 1; n <= 50; ++n) {
    FaultEntry entry;
    entry.fault = Fault::kOverspeed;
    entry.time_us = n;
    log.record(entry);
    REQUIRE(log.total() == n);
    REQUIRE(log.size() == (n < 16 ? n : 16));
    for (unsigned age = 0; age < log.size(); ++age) REQUIRE(log.entry(age).time_us == n - age);
    REQUIRE(log.entry(log.size()).fault == Fault::kNone);
  }
}
