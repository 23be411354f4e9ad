// A device that owns its link, and any device behind two virtual calls: what comes through them, and the link's report
// of it.
#include "hal/device_on_link.h"

#include <catch2/catch.hpp>

#include "hal/any_device.h"
#include "hal/loopback_link.h"
#include "hal/simulated_device.h"
#include "tests/support/rt_guard.h"
#include "tests/support/skip.h"

using namespace tactus;
using namespace tactus::hal;
using haptics::DeviceCommand;
using haptics::DeviceInput;
using haptics::DeviceState;
using haptics::ReadStatus;

namespace {

constexpr std::int64_t kPeriod_ns = 1'000'000;
using Device = DeviceOnLink<LoopbackLink>;

std::unique_ptr<Device> make_device() {
  const DeviceProfile& profile = *find_profile("virtuose6d");
  return std::make_unique<Device>(profile, kPeriod_ns,
                                  std::make_unique<LoopbackLink>(profile, HandModel{}, kPeriod_ns));
}

// `ticks` of a host that wants force.
void run(AnyDevice& device, int ticks, std::uint64_t& sequence, DeviceInput& input) {
  for (int i = 0; i < ticks; ++i) {
    device.read(input);
    DeviceCommand command;
    command.sequence = ++sequence;
    command.wanted = DeviceState::kForce;
    device.write(command);
  }
}

}  // namespace

TEST_CASE("a device behind the type-erased holder is the device itself: same samples, same properties") {
  const DeviceProfile& profile = *find_profile("desk3d");
  SimulatedDevice bare(profile, HandModel{}, {});
  AnyDevice held(std::make_unique<SimulatedDevice>(profile, HandModel{}, SimulationOptions{}));
  CHECK(held.properties().max_force_N == profile.properties.max_force_N);
  CHECK(held.as<SimulatedDevice>() != nullptr);
  CHECK(held.as<Device>() == nullptr);
  CHECK_FALSE(held.link_report().has_value());
  for (std::uint64_t tick = 1; tick <= 50; ++tick) {
    DeviceInput a, b;
    bare.read(a);
    held.read(b);
    CHECK(a.status == b.status);
    CHECK(a.sample.sequence == b.sample.sequence);
    CHECK(a.sample.state == b.sample.state);
    CHECK(a.sample.device_from_tool.position.x == b.sample.device_from_tool.position.x);
    DeviceCommand command;
    command.sequence = tick;
    command.wanted = DeviceState::kForce;
    command.wrench.force.x = 1;
    bare.write(command);
    held.write(command);
  }
  CHECK(held.as<SimulatedDevice>()->controller().state() == firmware::State::kForce);
}

TEST_CASE("every numbered frame is in the report: fresh, corrupt or lost by the gap in the numbers") {
  AnyDevice device(make_device());
  LoopbackLink& link = device.as<Device>()->link();
  std::uint64_t sequence = 0;
  DeviceInput input;
  run(device, 100, sequence, input);
  link.drop_states(7);
  run(device, 100, sequence, input);
  link.corrupt_states(4);
  run(device, 100, sequence, input);
  const auto report = device.link_report();
  REQUIRE(report.has_value());
  CHECK(report->lost == 7);
  CHECK(report->reads.corrupt == 4);
  CHECK(report->reads.missing == 7);
  CHECK(report->reads.fresh == 300 - 7 - 4);
  CHECK(report->link.sent == 300);
  CHECK(report->force_age.count() == 300);
}

TEST_CASE(
    "an unplugged device reads as disconnected, and what it missed meanwhile is counted as lost when it is back") {
  AnyDevice device(make_device());
  LoopbackLink& link = device.as<Device>()->link();
  std::uint64_t sequence = 0;
  DeviceInput input;
  run(device, 20, sequence, input);
  CHECK(input.status == ReadStatus::kFresh);
  link.set_plugged(false);
  run(device, 5, sequence, input);
  CHECK(input.status == ReadStatus::kDisconnected);
  link.set_plugged(true);
  run(device, 20, sequence, input);
  const auto report = device.link_report();
  CHECK(input.status == ReadStatus::kFresh);
  CHECK(report->reads.disconnected == 5);
  CHECK(report->lost == 5);  // the device lived on and numbered its frames
  CHECK(report->link.disconnects == 1);
}

TEST_CASE("the holder and its counts neither allocate nor lock in a tick") {
  AnyDevice device(make_device());
  std::uint64_t sequence = 0;
  DeviceInput input;
  run(device, 2, sequence, input);
  TACTUS_NEEDS(test::RtGuard::available(), "counting allocations needs a build without a sanitizer");
  const test::RtGuard guard;
  run(device, 100, sequence, input);
  const std::uint64_t allocations = guard.allocations(), locks = guard.locks();
  CHECK(allocations == 0);
  CHECK(locks == 0);
}
