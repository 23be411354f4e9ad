#include "tools/session/arm_gate.h"

#include <catch2/catch.hpp>

#include "rt/loop/haptic_loop.h"

using namespace tactus;
using namespace tactus::loop;
using tactus::session::ArmGate;

TEST_CASE("without a device to ask every request goes through at once") {
  ArmGate gate(nullptr);
  CHECK(gate.pass(kArm) == kArm);
  CHECK(gate.pass(kRearm | kReset) == (kRearm | kReset));
  CHECK(gate.look().ok());
}

namespace {

void let_start_pass(ArmGate& gate) {
  for (std::uint32_t tick = 0; tick < tactus::session::kIdleTicks; ++tick) CHECK(gate.pass(0) == 0);
}

}  // namespace

TEST_CASE("the tick after the first IDLE ones arms, later a request for force waits until the device is the same") {
  int asked = 0;
  bool same = true;
  ArmGate gate([&] {
    ++asked;
    return same ? Status::good() : Status::error("another device");
  });
  let_start_pass(gate);
  CHECK(gate.pass(kArm) == kArm);
  for (const auto bit : {kArm, kRearm}) {
    CHECK(gate.pass(bit | kReset) == kReset);
    CHECK(gate.pass(0) == 0);
    const int before = asked;
    CHECK(gate.look().ok());
    CHECK(asked == before + 1);
    CHECK(gate.pass(0) == bit);
    CHECK(gate.pass(0) == 0);
    CHECK(gate.look().ok());  // nobody waits: nobody is asked
    CHECK(asked == before + 1);
  }
  same = false;
  CHECK(gate.pass(kRearm) == 0);
  CHECK(gate.look().message() == "another device");
  CHECK(gate.pass(0) == 0);
  same = true;
  CHECK(gate.look().ok());  // what was refused was dropped
  CHECK(gate.pass(0) == 0);
}

TEST_CASE("disarming goes through at once and takes back what waits") {
  ArmGate gate([] { return Status::good(); });
  let_start_pass(gate);
  CHECK(gate.pass(0) == 0);
  CHECK(gate.pass(kRearm) == 0);
  CHECK(gate.pass(kDisarm) == kDisarm);
  CHECK(gate.look().ok());
  CHECK(gate.pass(0) == 0);
  CHECK(gate.pass(kArm) == 0);
  CHECK(gate.look().ok());
  CHECK(gate.pass(kDisarm) == kDisarm);
  CHECK(gate.pass(0) == 0);
}
