// A device through a maker's library: Force Dimension's, by a stand-in with the same functions.
#include <dlfcn.h>

#include <catch2/catch.hpp>

#include "hal/device_class.h"
#include "hal/sdk/dhd_port.h"
#include "hal/sdk/sdk_faults.h"
#include "hal/sdk/within.h"
#include "tests/hal/sdk/sdk_loop.h"
#include "tests/hal/sdk/stand_in/dhd.h"

using namespace tactus;
using namespace tactus::hal;
using Catch::Matchers::Contains;
using haptics::DeviceState;
using haptics::ReadStatus;
using test::kSdkPatience;
using test::kSdkPeriod_ns;
using test::SdkLoop;

namespace {

StandIn& truth() {
  void* const handle = dlopen(TACTUS_STAND_IN_DHD, RTLD_NOW | RTLD_LOCAL);
  REQUIRE(handle != nullptr);
  auto* const function = reinterpret_cast<decltype(&stand_in)>(dlsym(handle, "stand_in"));
  REQUIRE(function != nullptr);
  return *function();  // the handle stays: the library is not unloaded between two devices
}

// As it was loaded.
StandIn& reset() {
  StandIn& d = truth();
  d.count = 1;
  d.type = 33;
  d.result = 0;
  d.initialised = true;
  d.in_use = d.wrist = d.gone = d.refuses_force = d.forces_on = false;
  d.blocks_us = d.stops = d.closed = d.exchanges = 0;
  d.turn_rad = 0;
  d.major = 3;
  d.minor = 17;
  d.serial_asked = -1;
  d.says_nothing = d.refuses_expert = d.hangs = false;
  for (unsigned i = 0; i < 3; ++i) d.position_m[i] = d.speed_m_per_s[i] = 0;
  return d;
}

Result<std::unique_ptr<DhdPort>> open_port(std::optional<unsigned> serial = std::nullopt) {
  auto library = DhdLibrary::load(TACTUS_STAND_IN_DHD);
  REQUIRE(library.ok());
  return DhdPort::open(std::move(library).value(), serial);
}

std::unique_ptr<SdkDevice> open_device() {
  auto port = open_port();
  REQUIRE(port.ok());
  auto device = SdkDevice::start(std::move(port).value(), kSdkPeriod_ns);
  REQUIRE(device.ok());
  return std::move(device).value();
}

}  // namespace

TEST_CASE("dhd: a missing library, or one that lacks a function, gives one line with its name") {
  const auto nowhere = DhdLibrary::load("/nowhere");
  REQUIRE_FALSE(nowhere.ok());
  CHECK_THAT(nowhere.message(), Contains("is not found") && Contains("accepted: dhd:FOLDER"));
  const auto old = DhdLibrary::load(TACTUS_STAND_IN_DHD_OLD);
  REQUIRE_FALSE(old.ok());
  CHECK_THAT(old.message(), Contains("no function dhdGetStatus"));
}

TEST_CASE("dhd: a device that cannot be used is one line with the reason") {
  StandIn& d = reset();
  d.count = 0;
  CHECK_THAT(open_port().message(), Contains("no Force Dimension device"));
  d.count = 1;
  d.in_use = true;
  CHECK_THAT(open_port().message(), Contains("device is in use"));
  d.in_use = false;
  d.type = 60;
  CHECK_THAT(open_port().message(), Contains("type 60"));
  d.type = 33;
  d.initialised = false;
  CHECK_THAT(open_port().message(), Contains("not initialised"));
}

TEST_CASE("dhd: opened, it has limits, a watchdog of 10 ms, no time guard and no force, and closed it is stopped") {
  StandIn& d = reset();
  {
    const auto port = open_port();
    REQUIRE(port.ok());
    CHECK(port.value()->identity() == "Force Dimension omega.3, serial 1234, SDK 3.17.5");
    CHECK(port.value()->properties().max_force_N == 12);
    CHECK_FALSE(port.value()->properties().has_rotation);
    CHECK(d.watchdog_steps == 80);
    CHECK(d.time_guard_us == 0);
    CHECK_FALSE(d.forces_on);
    d.stops = 0;
  }
  CHECK(d.stops == 1);
  CHECK(d.closed == 1);
}

TEST_CASE("dhd: forces and places are turned between the frames, with the same work") {
  StandIn& d = reset();
  const auto port = open_port();
  REQUIRE(port.ok());
  SdkState state;
  d.position_m[0] = 0.01;
  d.position_m[1] = 0.02;
  d.position_m[2] = 0.03;
  const Wrenchd wrench{{1, 2, 3}, {}};
  REQUIRE(port.value()->exchange(wrench, state) == SdkResult::kFresh);
  const Vec3d place{d.position_m[0], d.position_m[1], d.position_m[2]};
  CHECK(state.device_from_tool.position.x == place.y);
  CHECK(state.device_from_tool.position.y == -place.x);
  CHECK(state.device_from_tool.position.z == place.z);
  const Vec3d force{d.force_N[0], d.force_N[1], d.force_N[2]};
  CHECK(dot(force, place) == Approx(dot(wrench.force, state.device_from_tool.position)));
  CHECK(state.buttons == 5);
}

TEST_CASE("dhd: a wrist that turns about the library's z turns about the device's z") {
  StandIn& d = reset();
  d.type = 104;
  d.wrist = true;
  d.turn_rad = 0.4;
  const auto port = open_port();
  REQUIRE(port.ok());
  SdkState state;
  REQUIRE(port.value()->exchange({}, state) == SdkResult::kFresh);
  const Quatd expected = quat_from_rotation_vector(Vec3d{0, 0, 0.4});
  CHECK(state.device_from_tool.rotation.w == Approx(expected.w));
  CHECK(state.device_from_tool.rotation.z == Approx(expected.z));
}

TEST_CASE("dhd: force reaches the library in FORCE alone, cut to the limit, and IDLE and the end switch it off",
          "[threads]") {
  StandIn& d = reset();
  {
    const auto device = open_device();
    CHECK(device->properties().delay_s >= 1e-3);
    SdkLoop loop{*device};
    REQUIRE(loop.push({30, 0, 0}, d.forces_on));
    CHECK(loop.until([&] { return std::abs(d.force_N[1] - 12) < 1e-9; }));
    CHECK(loop.is_fresh());
    loop.command.wanted = DeviceState::kIdle;
    CHECK(loop.until([&] { return !d.forces_on && d.force_N[1] == 0; }));
    REQUIRE(loop.push({1, 0, 0}, d.forces_on));
  }
  CHECK_FALSE(d.forces_on);
  CHECK(d.force_N[1] == 0);
}

TEST_CASE("dhd: a loop that stops altogether loses its force, and one that only reads latches fault 1", "[threads]") {
  StandIn& d = reset();
  const auto device = open_device();
  SdkLoop loop{*device};
  REQUIRE(loop.push({1, 0, 0}, d.forces_on));
  for (unsigned i = 0; i < kSdkPatience && d.forces_on; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  CHECK_FALSE(d.forces_on);
  REQUIRE(loop.push({1, 0, 0}, d.forces_on));
  CHECK(loop.until([&] { return loop.input.sample.device_fault == 1; }, false));
  CHECK(loop.input.sample.state == DeviceState::kBrake);
  CHECK(loop.until([&] { return !d.forces_on; }, false));
}

TEST_CASE("dhd: a device that switches its forces off, or refuses them, is a fault in words until the re-arm",
          "[threads]") {
  StandIn& d = reset();
  const auto device = open_device();
  SdkLoop loop{*device};
  REQUIRE(loop.push({1, 0, 0}, d.forces_on));
  d.forces_on = false;
  d.refuses_force = true;
  CHECK(loop.latches(kSdkForcesOff));
  d.refuses_force = false;
  CHECK(loop.rearms());
  CHECK(loop.push({1, 0, 0}, d.forces_on));
}

TEST_CASE("dhd: an old sample and a call that blocks are missing samples, a lost device is disconnected", "[threads]") {
  StandIn& d = reset();
  const auto device = open_device();
  SdkLoop loop{*device};
  REQUIRE(loop.is_fresh());
  d.result = 1;
  CHECK(loop.misses_five());
  d.result = 0;
  CHECK(loop.is_fresh());
  d.blocks_us = 50'000;
  CHECK(loop.misses_five());
  d.blocks_us = 0;
  CHECK(loop.is_fresh());
  d.gone = true;
  CHECK(loop.until([&] { return loop.input.status == ReadStatus::kDisconnected; }));
  d.gone = false;
  CHECK(loop.is_fresh());
}

TEST_CASE("dhd: a library that takes longer than the period allows is refused at the start") {
  StandIn& d = reset();
  d.blocks_us = 2'000;
  auto port = open_port();
  REQUIRE(port.ok());
  const auto device = SdkDevice::start(std::move(port).value(), kSdkPeriod_ns);
  REQUIRE_FALSE(device.ok());
  CHECK_THAT(device.message(), Contains("us for an exchange; accepted: at most 500"));
}

TEST_CASE("dhd: a library of another version is refused, with both versions") {
  StandIn& d = reset();
  const auto message = [&](int major, int minor) {
    d.major = major;
    d.minor = minor;
    return DhdLibrary::load(TACTUS_STAND_IN_DHD).message();
  };
  CHECK(message(3, 16).empty());
  CHECK(message(3, 99).empty());
  CHECK_THAT(message(3, 14), Contains("SDK 3.14.5") && Contains("accepted: 3.16"));
  CHECK_THAT(message(4, 1), Contains("SDK 4.1.5") && Contains("accepted: 3.16"));
  (void)reset();
}

TEST_CASE("dhd: a watchdog that cannot be set is reported with the device's name, and a missing text is no crash") {
  StandIn& d = reset();
  d.refuses_expert = true;
  {
    const auto port = open_port();
    REQUIRE(port.ok());
    CHECK_THAT(port.value()->identity(), Contains("omega.3, serial 1234, SDK 3.17.5;") &&
                                             Contains("watchdog could not be set to 10 ms") && Contains("time guard") &&
                                             Contains("no expert mode"));
  }
  d.says_nothing = true;
  CHECK_THAT(open_port().value()->identity(), Contains("device without a name"));
  d.in_use = true;
  CHECK_THAT(open_port().message(), Contains("cannot be opened: its library says no reason"));
  (void)reset();
}

TEST_CASE("dhd: one of several devices is opened by its serial number") {
  StandIn& d = reset();
  CHECK(open_port(1234).ok());
  CHECK(d.serial_asked == 1234);
  CHECK_THAT(open_port(99).message(), Contains("the device with serial 99 cannot be opened"));
  const DeviceClass& dhd = *find_device_class("dhd");
  const auto takes = [&](const char* address) { return dhd.takes(address, {}).front(); };
  CHECK(takes("").empty());
  CHECK(takes("/opt/sdk").empty());
  CHECK(takes("/opt/a,b").empty());  // a folder with a comma
  CHECK(takes("/opt/sdk,1234") == takes("/elsewhere,1234"));
  CHECK_FALSE(choose_device("dhd:/opt/sdk,").ok());
}

// The thread sanitizer calls a thread that is left on purpose a leak.
TEST_CASE("dhd: a call that never returns is left to itself at the end, and while the device is opened",
          "[no-tsan][threads]") {
  StandIn& d = reset();
  {
    const auto device = open_device();
    SdkLoop loop{*device};
    REQUIRE(loop.is_fresh());
    d.hangs = true;
    CHECK(loop.until([&] { return loop.input.status == ReadStatus::kDisconnected; }));
  }  // ends, although the call does not
  const unsigned stops = d.stops;
  d.hangs = false;  // then the thread that was left ends its force
  for (unsigned i = 0; i < kSdkPatience && d.stops == stops; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  CHECK(d.stops > stops);
  const auto hangs = std::make_shared<std::atomic<bool>>(true);
  const auto late = within<int>(std::chrono::seconds(0), "the library does not return", [hangs] {
    while (*hangs) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return Result<int>(1);
  });
  CHECK_THAT(late.message(), Contains("the library does not return after 0 s"));
  *hangs = false;
  const auto soon = within<int>(std::chrono::seconds(600), "late", [] { return Result<int>(7); });
  REQUIRE(soon.ok());
  CHECK(soon.value() == 7);
}
