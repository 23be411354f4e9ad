#include "hal/device_words.h"

#include <catch2/catch.hpp>
#include <set>

#include "hal/printable.h"

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

TEST_CASE("limits that hold back all force are told by number and in words, cuts of an effort are not") {
  CHECK(describe_device_limits(0).empty());
  CHECK(describe_device_limits(0xff).empty());
  CHECK_THAT(describe_device_limits(1u << 12), Contains("limit 76: homing is demanded and not done"));
  CHECK_THAT(describe_device_limits((1u << 9) | (1u << 10)), Contains("limit 73") && Contains("; limit 74"));
  CHECK_THAT(describe_device_limits(1u << 15), Contains("limit 79: this program does not know it"));
}

TEST_CASE("a latched fault's line says what the device says of it") {
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
