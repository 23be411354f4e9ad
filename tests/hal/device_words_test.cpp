#include "hal/device_words.h"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <set>

#include "hal/drives/drive_faults.h"
#include "hal/falcon/falcon_faults.h"
#include "hal/printable.h"
#include "hal/sdk/sdk_faults.h"

using namespace tactus;
using namespace tactus::hal;
using Catch::Contains;
using haptics::DeviceState;

TEST_CASE("every fault of a device has its number, words of its own and what to do") {
  std::set<std::string> words;
  for (std::uint32_t number = 1; number <= 9; ++number) {
    const std::string text = describe_device_fault(number);
    CHECK_THAT(text, Contains("device fault " + std::to_string(number) + ": ") && Contains(";"));
    CHECK_THAT(text, !Contains("does not know"));
    words.insert(text.substr(16));
  }
  CHECK(words.size() == 9);
  CHECK(describe_device_fault(0).empty());
  CHECK_THAT(describe_device_fault(63), Contains("device fault 63: this program does not know it"));
}

TEST_CASE("a number on tactus' own wire has the words of that wire alone, one of the host the words of its class") {
  for (std::uint32_t number = 1; number <= 0xffff; ++number) {  // all that the wire can carry
    const std::string text = describe_device_fault(number);
    REQUIRE_THAT(text, Contains(fmt::format("device fault {}: ", number)));
    REQUIRE_THAT(text, !Contains("drive of axis") && !Contains("its library"));
    REQUIRE(text.ends_with("this program does not know it; see the device's manual, clear it, then re-arm") ==
            (number > 9));
  }
  for (const auto& [fault, number, words] :
       {std::tuple{kDriveLeftForce + 1, 41, "the drive of axis 1"},
        {drive_fault_of(2, DriveFamily::kMoteus, 34), 34,
         "the drive of axis 2 reports a fault: fault 34, over-voltage"},
        {drive_left_force(5, DriveFamily::kMoteus, DriveMode::kTimedOut), 45, "its watchdog acted"},
        {kDriveSilent, 48, "does not answer"},
        {kDriveLacksTorque, 56, "without the torque"},
        {kFalconNotHomed, 80, "pull the grip out"},
        {kSdkTooFast, 100, "its library says that the arm moved too fast"},
        {kSdkForcesOff, 106, "its library switched the forces off"}}) {
    CHECK(shown_fault(fault) == static_cast<std::uint32_t>(number));
    CHECK_THAT(describe_device_fault(fault),
               Contains(fmt::format("device fault {}: ", number)) && Contains(words) && Contains("re-arm"));
  }
}

TEST_CASE("no number from outside is taken for one of the host's") {
  for (const std::uint32_t number : {0u, 1u, 40u, 0xffffu, kOfHost - 1, kOfHost, kOfHost | 40u, 0xffffffffu}) {
    const std::uint32_t kept = without_host_bit(number);
    CHECK((kept & kOfHost) == 0);
    CHECK((kept == 0) == (number == 0));
    if (number < kOfHost) CHECK(kept == number);
  }
}

TEST_CASE("limits that withhold all force are reported by number and in words, a limited effort is not") {
  CHECK(describe_device_limits(0).empty());
  CHECK(describe_device_limits(0xff).empty());
  CHECK_THAT(describe_device_limits(1u << 12), Contains("limit 76: homing is demanded and not done"));
  CHECK_THAT(describe_device_limits((1u << 9) | (1u << 10)), Contains("limit 73") && Contains("; limit 74"));
  CHECK_THAT(describe_device_limits(1u << 15), Contains("limit 79: this program does not know it"));
}

TEST_CASE("the line of a latched fault contains the device's own report") {
  CHECK_THAT(describe(Fault::kDeviceFault, {DeviceState::kBrake, 5, 0}),
             Contains("device fault 5: the motors' supply"));
  CHECK_THAT(describe(Fault::kDeviceFault, {DeviceState::kBrake, 0, 0}), Contains("by number"));
  CHECK_THAT(describe(Fault::kForceRefused, {DeviceState::kIdle, 0, 1u << 12}),
             Contains("it is in IDLE") && Contains("limit 76"));
  CHECK_THAT(describe(Fault::kDeviceLeftForce, {DeviceState::kReset, 0, 0}), Contains("it is in RESET"));
  CHECK(describe(Fault::kNone, {DeviceState::kBrake, 5, 0}) == tactus::describe(Fault::kNone));
  CHECK_THAT(describe(Fault::kDeviceUnplugged, {}), Contains("re-arm") && !Contains("start again"));
}

TEST_CASE("text from outside reaches no terminal as it is") {
  CHECK(printable("BENCH-1") == "BENCH-1");
  CHECK(printable("\x1b[31mA\n\xff\\") == "\\x1b[31mA\\x0a\\xff\\x5c");
}
