#include "hal/loopback_link.h"

#include <catch2/catch.hpp>

#include "hal/linked_device.h"
#include "hal/simulated_device.h"
#include "tests/support/rt_guard.h"
#include "tests/support/skip.h"

using namespace tactus;
using namespace tactus::hal;
using haptics::DeviceInput;
using haptics::DeviceState;
using haptics::ReadStatus;

namespace {

constexpr std::int64_t kPeriod_ns = 1'000'000;

const std::vector<HandWaypoint> kWave{{0.0, {}, {}},
                                      {0.4, {0.05, -0.03, 0.02}, {0.2, -0.4, 0.3}},
                                      {0.8, {-0.04, 0.02, -0.03}, {-0.3, 0.5, 0.1}},
                                      {1.2, {}, {}}};

// A host that answers every sample with the same wrench.
struct Rig {
  LoopbackLink link;
  LinkedDevice<LoopbackLink> device;
  DeviceInput input;
  haptics::DeviceCommand command;

  explicit Rig(const HandModel& hand = HandModel())
      : link(*find_profile("virtuose6d"), hand, kPeriod_ns), device(*find_profile("virtuose6d"), kPeriod_ns, link) {
    command.wanted = DeviceState::kForce;
  }
  ReadStatus tick() {
    device.read(input);
    ++command.sequence;
    device.write(command);
    return input.status;
  }
  void ticks(int n) {
    for (int i = 0; i < n; ++i) tick();
  }
  double force() const { return norm(link.plant().motor_wrench().force); }
};

}  // namespace

TEST_CASE("a device on the loopback gives the samples and the motions of the simulated device") {
  const HandModel hand({}, kWave);
  Rig rig(hand);
  SimulatedDevice reference(*find_profile("virtuose6d"), hand, {});
  DeviceInput expected;
  for (int i = 0; i < 1500; ++i) {
    rig.command.wrench = {{3, -2, 1}, {0.1, 0.05, -0.1}};
    reference.read(expected);
    rig.tick();
    reference.write(rig.command);
    REQUIRE(rig.input.status == ReadStatus::kFresh);
    REQUIRE(rig.input.sample.device_from_tool == expected.sample.device_from_tool);
    REQUIRE(rig.input.sample.device_time_ns == expected.sample.device_time_ns);
    REQUIRE(rig.input.sample.echoed_sequence == expected.sample.echoed_sequence);
    REQUIRE(rig.link.plant().coordinates() == reference.plant().coordinates());
    REQUIRE(rig.device.newest_arrival_ns() == (i + 1) * kPeriod_ns);
  }
  CHECK(rig.link.counters().received == 1500);
  CHECK(rig.link.counters().sent == 1500);
}

TEST_CASE("an unplugged loopback is disconnected, its device brakes by itself and is back when plugged in") {
  Rig rig;
  rig.command.wrench.force.x = 2;
  rig.ticks(10);
  CHECK(rig.force() == Approx(2.0));
  rig.link.set_plugged(false);
  for (int i = 0; i < 20; ++i) CHECK(rig.tick() == ReadStatus::kDisconnected);
  CHECK(rig.force() == 0.0);
  CHECK(rig.device.counters().not_sent == 20);
  CHECK(rig.link.counters().disconnects == 1);
  CHECK_FALSE(rig.link.call({}, std::chrono::milliseconds(1)).ok());
  rig.link.set_plugged(true);
  CHECK(rig.tick() == ReadStatus::kFresh);
  CHECK(rig.input.sample.state == DeviceState::kBrake);
}

TEST_CASE("a device that lost its power starts afresh") {
  Rig rig;
  rig.command.wrench.force.x = 2;
  rig.ticks(50);
  const std::uint64_t sequence = rig.input.sample.sequence;
  rig.link.set_powered(false);
  CHECK(rig.tick() == ReadStatus::kDisconnected);
  CHECK(rig.force() == Approx(2.0));  // of the last sub-step that there was
  rig.link.set_powered(true);
  rig.tick();
  CHECK(rig.input.sample.sequence < sequence);
  rig.ticks(5);
  CHECK(rig.input.sample.state == DeviceState::kIdle);  // whoever goes on wanting FORCE gets none
  CHECK(rig.force() == 0.0);
  rig.command.wanted = DeviceState::kIdle;
  rig.ticks(2);
  rig.command.wanted = DeviceState::kForce;
  rig.ticks(5);
  CHECK(rig.input.sample.state == DeviceState::kForce);
}

TEST_CASE("dropped and corrupted frames go missing in their direction alone") {
  Rig rig;
  rig.ticks(10);
  rig.link.drop_states(2);
  CHECK((rig.tick() == ReadStatus::kMissing && rig.tick() == ReadStatus::kMissing));
  CHECK(rig.tick() == ReadStatus::kFresh);
  rig.link.corrupt_states(1);
  CHECK(rig.tick() == ReadStatus::kCorrupt);
  CHECK(rig.tick() == ReadStatus::kFresh);
  CHECK(rig.link.device().controller().missed_commands() == 0);
  rig.link.drop_commands(4);
  rig.ticks(5);
  CHECK(rig.link.device().controller().missed_commands() == 4);
  rig.ticks(1);
  CHECK(rig.link.device().controller().missed_commands() == 0);
  const auto refused = rig.link.device().controller().refused_frames();
  rig.link.corrupt_commands(3);
  rig.ticks(5);
  CHECK(rig.link.device().controller().refused_frames() == refused + 3);
}

TEST_CASE("the loopback's e-stop and supply reach the firmware") {
  Rig rig;
  rig.command.wrench.force.x = 2;
  rig.ticks(10);
  rig.link.set_emergency_stop(true);
  rig.tick();
  CHECK(rig.input.sample.device_fault == static_cast<unsigned>(firmware::Fault::kEmergencyStop));
  CHECK(rig.link.motor_outputs().effort == firmware::AxisValues{});
  Rig other;
  other.ticks(10);
  other.link.set_motor_bus(false);
  other.tick();
  CHECK(other.input.sample.device_fault == static_cast<unsigned>(firmware::Fault::kMotorBus));
}

TEST_CASE("the loopback neither allocates nor locks", "[no-asan][no-tsan]") {
  Rig rig{HandModel({}, kWave)};
  rig.tick();
  TACTUS_NEEDS(test::RtGuard::available(), "counting allocations needs a build without a sanitizer");
  const test::RtGuard guard;
  rig.ticks(1000);
  CHECK(guard.allocations() == 0);
  CHECK(guard.frees() == 0);
  CHECK(guard.locks() == 0);
}
