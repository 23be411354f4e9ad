#include "hal/device_record.h"

#include <catch2/catch.hpp>

#include "hal/loopback_link.h"

using namespace tactus;
using namespace tactus::hal;
using Catch::Contains;
namespace number = firmware::number;

namespace {

constexpr std::chrono::milliseconds kPatience{100};

// A loopback of which one register may have another value.
struct ChangedLink : LoopbackLink {
  ChangedLink() : LoopbackLink(*find_profile("virtuose6d"), HandModel(), 1'000'000) {}
  std::uint16_t changed{0xffff};
  std::uint32_t value{0};
  bool silent{false};

  Result<firmware::ServiceMessage> call(const firmware::ServiceMessage& request, std::chrono::milliseconds patience) {
    if (silent) return Status::error("link: no answer in time");
    auto reply = LoopbackLink::call(request, patience);
    if (reply.ok() && request.address == changed) reply.value().value = value;
    return reply;
  }
};

std::string difference(std::uint16_t address, std::uint32_t value) {
  ChangedLink link;
  const auto began_with = DeviceRecord::read(link, kPatience);
  REQUIRE(began_with.ok());
  REQUIRE(began_with.value().compare(link, kPatience).ok());
  link.changed = address;
  link.value = value;
  return began_with.value().compare(link, kPatience).message();
}
std::string difference(std::uint16_t address, float value) {
  return difference(address, std::bit_cast<std::uint32_t>(value));
}

}  // namespace

TEST_CASE("a register that changed since the start of the run is reported: name, both values, remedy") {
  const firmware::Config config = firmware_config(*find_profile("virtuose6d"), 1000);
  for (std::uint16_t axis = 0; axis < 6; ++axis) {
    const std::string of = fmt::format(" of axis {} (register 0x0", axis);
    const auto at = [axis](std::uint16_t first) { return static_cast<std::uint16_t>(first + axis); };
    CHECK_THAT(difference(at(number::kQuantum), 2 * config.quantum[axis]),
               Contains("its quantum" + of) && Contains(fmt::format("began with {:.9g}", config.quantum[axis])));
    CHECK_THAT(difference(at(number::kMaxEffort), 1e6f), Contains("its max_effort" + of) && Contains("is 1000000"));
    CHECK_THAT(difference(at(number::kMaxSpeed), 1e6f), Contains("its max_speed" + of));
    CHECK_THAT(difference(at(number::kDirection), static_cast<std::uint32_t>(-1)),
               Contains("its direction" + of) && Contains("is -1"));
    CHECK_THAT(difference(at(number::kOffset), 12u), Contains("its offset" + of));
  }
  CHECK_THAT(difference(number::kMaxForce, 1e6f), Contains("its max_force (register 0x0130) is 1000000"));
  CHECK_THAT(difference(number::kMaxTorque, 1e6f), Contains("its max_torque"));
  CHECK_THAT(difference(number::kFadeFrames, 200u), Contains("its fade_frames (register 0x0133) is 200, this run "
                                                             "began with 3; write it back, or end the run"));
  CHECK_THAT(difference(number::kBrakeFrames, 250u), Contains("its brake_frames"));
  CHECK_THAT(difference(number::kDeviceClass, 1u), Contains("its device_class"));
  CHECK_THAT(difference(number::kPeriod, 500u), Contains("its period"));
  CHECK_THAT(difference(number::kProtocol, 2u), Contains("its protocol_version"));
}

TEST_CASE("another device is detected by its serial number, whatever characters that has") {
  CHECK_THAT(difference(number::kSerial, 0x00003142u), Contains("its serial number is 'B1', this run began with ''"));
  CHECK_THAT(difference(number::kSerial, 0x6d315b1bu), Contains("'\\x1b[1m'") && !Contains("\x1b"));
}

TEST_CASE("a device that does not answer is not the same one") {
  ChangedLink link;
  const auto began_with = DeviceRecord::read(link, kPatience);
  REQUIRE(began_with.ok());
  link.silent = true;
  CHECK(began_with.value().compare(link, kPatience).message() == "link: no answer in time");
  CHECK_FALSE(DeviceRecord::read(link, kPatience).ok());
}
