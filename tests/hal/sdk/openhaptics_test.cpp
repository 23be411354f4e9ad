// A device through a library with a scheduler of its own: 3D Systems' HD, by a stand-in with the same functions.
#include <dlfcn.h>

#include <catch2/catch.hpp>

#include "hal/device_class.h"
#include "hal/device_words.h"
#include "hal/sdk/hd_port.h"
#include "hal/sdk/sdk_faults.h"
#include "tests/hal/sdk/sdk_loop.h"
#include "tests/hal/sdk/stand_in/hd.h"

using namespace tactus;
using namespace tactus::hal;
using Catch::Matchers::Contains;
using haptics::DeviceState;
using haptics::ReadStatus;
using test::kSdkPatience;
using test::kSdkPeriod_ns;
using test::SdkLoop;

namespace {

HdStandIn& truth() {
  void* const handle = dlopen(TACTUS_STAND_IN_HD, RTLD_NOW | RTLD_LOCAL);
  REQUIRE(handle != nullptr);
  auto* const function = reinterpret_cast<decltype(&hd_stand_in)>(dlsym(handle, "hd_stand_in"));
  REQUIRE(function != nullptr);
  return *function();  // the handle stays: the library is not unloaded between two devices
}

// As it was loaded.
HdStandIn& reset() {
  HdStandIn& d = truth();
  d.init_error = d.error = d.calibrations = d.calibrations_in_force = d.blocks_us = d.frames = d.outside_of_frames =
      d.disabled = d.stopped = 0;
  d.calibration = 0x5000;
  d.rate_Hz = 1000;
  d.output_dof = 3;
  d.largest_force_N = 3.3;
  d.version = '3';
  d.calls = true;
  d.backwards = d.refuses_force = d.forces_on = d.broken_matrix = false;
  d.glitch_mm = d.turn_rad = 0;
  for (int i = 0; i < 3; ++i) d.position_mm[i] = d.force_N[i] = d.torque_mNm[i] = 0;
  return d;
}

Result<std::unique_ptr<HdPort>> open_port(const std::string& name = {}) {
  auto library = HdLibrary::load(TACTUS_STAND_IN_HD);
  REQUIRE(library.ok());
  return HdPort::open(std::move(library).value(), name);
}

Result<std::unique_ptr<SdkDevice>> start() {
  auto port = open_port();
  REQUIRE(port.ok());
  return SdkDevice::start(std::move(port).value(), kSdkPeriod_ns);
}

std::unique_ptr<SdkDevice> open_device() {
  auto device = start();
  INFO(device.message());
  REQUIRE(device.ok());
  return std::move(device).value();
}

}  // namespace

TEST_CASE("openhaptics: a missing library, or one that lacks a function, gives one line with its name") {
  const auto nowhere = HdLibrary::load("/nowhere");
  REQUIRE_FALSE(nowhere.ok());
  CHECK_THAT(nowhere.message(), Contains("is not found") && Contains("accepted: openhaptics:FOLDER"));
  const auto old = HdLibrary::load(TACTUS_STAND_IN_HD_OLD);
  REQUIRE_FALSE(old.ok());
  CHECK_THAT(old.message(), Contains("no function hdCheckCalibration"));
}

TEST_CASE("openhaptics: a device that cannot be used is one line with the reason") {
  HdStandIn& d = reset();
  d.init_error = 0x0600;
  CHECK_THAT(open_port().message(), Contains("cannot be opened") && Contains("invalid license (error 0x0600)"));
  d.init_error = 0;
  CHECK_THAT(open_port("Right Device").message(), Contains("cannot be opened") && Contains("0x0302"));
  CHECK(open_port("Left Device").ok());
  d.version = '2';
  CHECK_THAT(open_port().message(), Contains("the library is HD 2.4.0; accepted: OpenHaptics 3.0"));
  d.version = '3';
  d.largest_force_N = 0;
  CHECK_THAT(open_port().message(), Contains("make no sense (0 N, 0.88 N for long"));
}

TEST_CASE("openhaptics: opened, it has the library's limits, no force, and closed it is stopped and let go",
          "[threads]") {
  HdStandIn& d = reset();
  d.forces_on = true;
  {
    const auto port = open_port();
    REQUIRE(port.ok());
    CHECK(port.value()->identity() == "3D Systems Touch, serial 1234, HD 3.4.0");
    const haptics::DeviceProperties& p = port.value()->properties();
    CHECK(p.max_force_N == 3.3);
    CHECK(p.continuous_force_N == 0.88);
    CHECK_FALSE(p.has_rotation);
    CHECK(p.workspace_radius_m == Approx(std::hypot(0.21, 0.205, 0.13)));  // the farthest corner that it reaches
    CHECK_FALSE(d.forces_on);
  }
  CHECK(d.disabled == 1);
  (void)open_device();
  CHECK(d.stopped == 1);
  CHECK(d.disabled == 2);
}

TEST_CASE("openhaptics: forces, torques, places and turns are in SI and in the device's frame, with the same work") {
  HdStandIn& d = reset();
  d.output_dof = 6;
  d.position_mm[0] = 1;
  d.position_mm[1] = 2;
  d.position_mm[2] = 3;
  d.turn_rad = 0.4;
  const auto port = open_port();
  REQUIRE(port.ok());
  CHECK(port.value()->properties().has_rotation);
  SdkState state;
  const Wrenchd wrench{{1, 2, 3}, {0.01, 0.02, 0.03}};
  REQUIRE(port.value()->exchange(wrench, state) == SdkResult::kFresh);
  const Vec3d& at = state.device_from_tool.position;
  CHECK(at.x == Approx(1e-3));
  CHECK(at.y == Approx(-3e-3));  // away from the person
  CHECK(at.z == Approx(2e-3));   // up
  const Vec3d force{d.force_N[0], d.force_N[1], d.force_N[2]},
      torque{d.torque_mNm[0], d.torque_mNm[1], d.torque_mNm[2]};
  CHECK(dot(force, Vec3d{1e-3, 2e-3, 3e-3}) == Approx(dot(wrench.force, at)));
  // The library's y is the device's z: the turn, and the torque that does work by it.
  const Quatd expected = quat_from_rotation_vector(Vec3d{0, 0, 0.4});
  CHECK(state.device_from_tool.rotation.w == Approx(expected.w));
  CHECK(state.device_from_tool.rotation.z == Approx(expected.z));
  CHECK(torque.y == Approx(30));
  CHECK(state.buttons == 2);
  CHECK(d.outside_of_frames == 0);
}

TEST_CASE("openhaptics: a pose that jumps or is none is not fresh, and the next one is") {
  HdStandIn& d = reset();
  const auto port = open_port();
  REQUIRE(port.ok());
  SdkState state;
  REQUIRE(port.value()->exchange({}, state) == SdkResult::kFresh);
  d.glitch_mm = 5.5;
  CHECK(port.value()->exchange({}, state) == SdkResult::kError);
  CHECK(port.value()->exchange({}, state) == SdkResult::kFresh);  // it stays there: the arm is there
  d.glitch_mm = 1.5;
  CHECK(port.value()->exchange({}, state) == SdkResult::kFresh);
  d.broken_matrix = true;
  CHECK(port.value()->exchange({}, state) == SdkResult::kError);
}

TEST_CASE("openhaptics: force reaches the library in FORCE alone, cut to the limit, and IDLE and the end switch it off",
          "[threads]") {
  HdStandIn& d = reset();
  {
    const auto device = open_device();
    CHECK(device->properties().delay_s >= 1e-3);
    SdkLoop loop{*device};
    REQUIRE(loop.push({0, 30, 0}, d.forces_on));
    CHECK(loop.until([&] { return std::abs(d.force_N[2] + 3.3) < 1e-9; }));
    CHECK(loop.is_fresh());
    loop.command.wanted = DeviceState::kIdle;
    CHECK(loop.until([&] { return !d.forces_on && d.force_N[2] == 0; }));
    REQUIRE(loop.push({0, 1, 0}, d.forces_on));
  }
  CHECK_FALSE(d.forces_on);
  CHECK(d.force_N[2] == 0);
  CHECK(d.outside_of_frames == 0);
}

TEST_CASE("openhaptics: a loop that stops altogether loses its force, and one that only reads latches fault 1",
          "[threads]") {
  HdStandIn& d = reset();
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

TEST_CASE("openhaptics: what the library reports is a fault in words, latched until the re-arm, without force at once",
          "[threads]") {
  HdStandIn& d = reset();
  const auto device = open_device();
  SdkLoop loop{*device};
  for (const auto& [code, fault, words] : {std::tuple{0x0200u, kSdkMotorsWarm, "warm"},
                                           {0x0201u, kSdkForceTooLarge, "too large"},
                                           {0x0202u, kSdkForceTooSudden, "rose too fast"},
                                           {0x0203u, kSdkTooFast, "moved too fast"},
                                           {0x0204u, kSdkForceError, "no force"},
                                           {0x0300u, kSdkDeviceFault, "the device has a fault"},
                                           {0x0302u, kSdkConnectionLost, "lost the device"},
                                           {0x0600u, kSdkLicenceRefused, "licence"}}) {
    CAPTURE(code);
    REQUIRE(loop.push({1, 0, 0}, d.forces_on));
    d.error = code;
    CHECK(loop.latches(fault));
    CHECK(loop.until([&] { return !d.forces_on && d.force_N[0] == 0; }));
    CHECK_THAT(describe_device_fault(loop.input.sample.device_fault), Contains(words) && Contains("its library"));
    d.error = 0;
    CHECK(loop.is_fresh());
    CHECK(loop.input.sample.device_fault == fault);
    CHECK(loop.rearms());
  }
}

TEST_CASE("openhaptics: a fault ends the force before the haptic thread has read it", "[threads]") {
  HdStandIn& d = reset();
  const auto device = open_device();
  SdkLoop loop{*device};
  REQUIRE(loop.push({1, 0, 0}, d.forces_on));
  d.error = 0x0302;
  // It goes on asking for force, for as long as it does not read.
  unsigned off = 0;
  for (unsigned i = 0; i < kSdkPatience && off < 30; ++i) {
    ++loop.command.sequence;
    device->write(loop.command);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    if (off > 0) CHECK_FALSE(d.forces_on);
    off += !d.forces_on;
  }
  CHECK(off == 30);
  CHECK(loop.latches(kSdkConnectionLost));
}

TEST_CASE("openhaptics: forces that go off by themselves, or are refused, are fault 5 until the re-arm", "[threads]") {
  HdStandIn& d = reset();
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

TEST_CASE("openhaptics: a device that requests calibration is calibrated without force, and in FORCE that is a fault",
          "[threads]") {
  HdStandIn& d = reset();
  d.calibration = 0x5002;  // a person has to do something
  const auto refused = start();
  REQUIRE_FALSE(refused.ok());
  CHECK_THAT(refused.message(), Contains("not calibrated") && Contains("inkwell"));
  d.calibration = 0x5001;
  const auto device = open_device();
  CHECK(d.calibrations == 1);
  SdkLoop loop{*device};
  REQUIRE(loop.push({1, 0, 0}, d.forces_on));
  d.calibration = 0x5001;
  CHECK(loop.latches(kSdkNotCalibrated));
  CHECK(loop.until([&] { return d.calibrations == 2; }));  // in BRAKE, without force
  CHECK(d.calibrations_in_force == 0);
  CHECK(loop.rearms());
}

TEST_CASE("openhaptics: a call that blocks is missing samples, a clock that runs backwards a fault", "[threads]") {
  HdStandIn& d = reset();
  const auto device = open_device();
  SdkLoop loop{*device};
  REQUIRE(loop.is_fresh());
  d.blocks_us = 50'000;
  CHECK(loop.misses_five());
  d.blocks_us = 0;
  CHECK(loop.is_fresh());
  REQUIRE(loop.push({1, 0, 0}, d.forces_on));
  d.backwards = true;
  CHECK(loop.latches(kSdkTimeWentBack));
  CHECK(loop.until([&] { return !d.forces_on; }));
  d.backwards = false;
  CHECK(loop.is_fresh());
}

TEST_CASE("openhaptics: a scheduler that calls no more is a device that is not there, and the end does not wait for it",
          "[threads]") {
  HdStandIn& d = reset();
  {
    const auto device = open_device();
    SdkLoop loop{*device};
    REQUIRE(loop.push({1, 0, 0}, d.forces_on));
    d.calls = false;
    CHECK(loop.until([&] { return loop.input.status == ReadStatus::kDisconnected; }));
  }
  CHECK_FALSE(d.forces_on);
  CHECK(d.force_N[0] == 0);
}

TEST_CASE("openhaptics: a scheduler of another rate, that never calls or is too slow is refused at the start",
          "[threads]") {
  HdStandIn& d = reset();
  d.rate_Hz = 500;
  CHECK_THAT(start().message(), Contains("runs at 500 Hz; accepted: --rate 500"));
  d.rate_Hz = 1000;
  d.blocks_us = 700;
  CHECK_THAT(start().message(), Contains("us for an exchange; accepted: at most 500"));
  d.blocks_us = 0;
  d.calls = false;
  CHECK_THAT(start().message(), Contains("made 0 of 200 calls"));
  CHECK_FALSE(d.forces_on);
}

TEST_CASE("openhaptics: the class takes a folder and a name, and says what the machine has") {
  const DeviceClass& hd = *find_device_class("openhaptics");
  CHECK(choose_device("openhaptics").ok());
  CHECK(choose_device("openhaptics:,Left Device").ok());
  CHECK_FALSE(choose_device("openhaptics:/opt,").ok());
  CHECK_FALSE(hd.look("/nowhere").ok());
  CHECK(hd.look(TACTUS_STAND_IN_HD).value() == "3D Systems' library HD is " TACTUS_STAND_IN_HD);
}
