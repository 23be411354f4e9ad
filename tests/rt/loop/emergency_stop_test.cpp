// The e-stop's status line beside the link, as the loop takes it.
#include <catch2/catch.hpp>

#include "tests/rt/loop/haptic_loop_bench.h"

using namespace tactus;
using namespace tactus::loop;
using namespace tactus::test::haptic_loop_bench;

TEST_CASE("an active e-stop line gives zero force and requests BRAKE in the same tick, and latches") {
  Bench bench;
  bench.hold({0.002, 0, 0});
  REQUIRE(bench.force() == Approx(0.002 * kStiffness).epsilon(0.02));
  bench.tick(kEmergencyStopLine);
  CHECK(bench.force() == 0);
  CHECK(norm(bench.out.command.wrench.torque) == 0);
  CHECK(bench.out.command.wanted == DeviceState::kBrake);
  CHECK(bench.out.fault == Fault::kEmergencyStop);
  bench.run(100);  // released: latched all the same
  CHECK(bench.force() == 0);
  CHECK(bench.out.fault == Fault::kEmergencyStop);
}

TEST_CASE("a re-arm while the e-stop line is active does nothing, and brings the force back once it is released") {
  Bench bench;
  bench.hold({0.002, 0, 0});
  bench.tick(kEmergencyStopLine);
  for (int i = 0; i < 20; ++i) {
    bench.tick(kEmergencyStopLine | (i == 10 ? kRearm : 0u));
    CHECK(bench.out.fault == Fault::kEmergencyStop);
    CHECK(bench.force() == 0);
    CHECK(bench.out.command.rearm == 0);
  }
  bench.tick(kRearm);
  CHECK(bench.out.fault == Fault::kNone);
  bench.run(5);
  bench.move({0.002, 0, 0});
  bench.run(300);
  CHECK(bench.out.command.wanted == DeviceState::kForce);
  CHECK(bench.force() > 1);
}

TEST_CASE("an e-stop line that comes after another fault leaves the first cause named, and ends its fade") {
  Bench bench;
  bench.hold({0.002, 0, 0});
  bench.tick(0, ReadStatus::kDisconnected);
  REQUIRE(bench.out.fault == Fault::kDeviceUnplugged);
  REQUIRE(bench.force() > 0);
  bench.tick(kEmergencyStopLine, ReadStatus::kDisconnected);
  CHECK(bench.out.fault == Fault::kDeviceUnplugged);
  CHECK(bench.force() == 0);
}
