#include "hal/identity_check.h"

#include <catch2/catch.hpp>

#include "hal/loopback_link.h"

using namespace tactus;
using namespace tactus::hal;
using Catch::Contains;
namespace number = firmware::number;

namespace {

constexpr std::int64_t kPeriod_ns = 1'000'000;

// A loopback whose answers a test may spoil.
struct SpoiltLink : LoopbackLink {
  explicit SpoiltLink(const DeviceProfile& profile) : LoopbackLink(profile, HandModel(), kPeriod_ns) {}
  std::uint16_t spoilt{0xffff};
  std::uint32_t value{0};
  bool silent{false}, refuses{false};

  Result<firmware::ServiceMessage> call(const firmware::ServiceMessage& request, std::chrono::milliseconds patience) {
    if (request.address != spoilt) return LoopbackLink::call(request, patience);
    if (silent) return Status::error("link: no answer in time; is the device on?");
    firmware::ServiceMessage reply = request;
    reply.value = value;
    if (refuses) reply.status = firmware::ServiceStatus::kNoSuchRegister;
    return reply;
  }
};
static_assert(FrameLink<SpoiltLink>);

std::string verdict(std::string_view profile, std::uint16_t address, std::uint32_t value) {
  SpoiltLink link(*find_profile(profile));
  link.spoilt = address;
  link.value = value;
  return check_identity(*find_profile(profile), 1000, link).message();
}
std::string verdict(std::string_view profile, std::uint16_t address, double value) {
  return verdict(profile, address, std::bit_cast<std::uint32_t>(static_cast<float>(value)));
}

}  // namespace

TEST_CASE("a device that is configured from its description passes, at every rate") {
  for (const DeviceProfile& profile : all_profiles())
    for (const std::int64_t period_ns : {250'000, 1'000'000}) {
      LoopbackLink link(profile, HandModel(), period_ns);
      const Status status = check_identity(profile, static_cast<std::uint32_t>(period_ns / 1000), link);
      INFO(status.message());
      CHECK(status.ok());
    }
}

TEST_CASE("the device of another description does not pass") {
  LoopbackLink desk(*find_profile("desk3d"), HandModel(), kPeriod_ns);
  CHECK_FALSE(check_identity(*find_profile("virtuose6d"), 1000, desk).ok());
  LoopbackLink virtuose(*find_profile("virtuose6d"), HandModel(), kPeriod_ns);
  CHECK_FALSE(check_identity(*find_profile("desk3d"), 1000, virtuose).ok());
}

TEST_CASE("every relevant difference is reported, with both figures and the remedy") {
  const DeviceProfile& p = *find_profile("virtuose6d");
  CHECK_THAT(verdict("virtuose6d", number::kProtocol, 2u), Contains("protocol version is 2") && Contains("firmware"));
  CHECK_THAT(verdict("virtuose6d", number::kPeriod, 500u), Contains("is 500") && Contains("has 1000; run at"));
  CHECK_THAT(verdict("virtuose6d", number::kFadeFrames, 9u), Contains("fades is 9") && Contains("has 3"));
  CHECK_THAT(verdict("virtuose6d", number::kBrakeFrames, 200u), Contains("brake is 200") && Contains("has 10"));
  CHECK_THAT(verdict("virtuose6d", number::kDeviceClass, 1u), Contains("device class is 1"));
  CHECK(verdict("virtuose6d", number::kDeviceClass, 2u).empty());
  CHECK(verdict("virtuose6d", number::kDeviceClass, 77u).empty());  // one that this program does not know yet
  CHECK_THAT(verdict("desk3d", number::kDeviceClass, 2u), Contains("device class is 2"));
  for (std::uint16_t axis = 0; axis < 6; ++axis) {
    const std::string of = " of axis " + std::to_string(axis);
    const auto at = [axis](std::uint16_t first) { return static_cast<std::uint16_t>(first + axis); };
    const double quantum = p.quantum[axis], effort = p.bounds.effort[axis], rate = p.bounds.rate[axis];
    CHECK_THAT(verdict("virtuose6d", at(number::kQuantum), 1.0001 * quantum), Contains("quantum" + of));
    CHECK_THAT(verdict("virtuose6d", at(number::kQuantum), -quantum), Contains("quantum" + of));
    CHECK(verdict("virtuose6d", at(number::kQuantum), 1.000001 * quantum).empty());
    CHECK_THAT(verdict("virtuose6d", at(number::kMaxEffort), 0.9 * effort), Contains("effort limit" + of));
    CHECK_THAT(verdict("virtuose6d", at(number::kMaxEffort), 1.6 * effort), Contains("effort limit" + of));
    CHECK(verdict("virtuose6d", at(number::kMaxEffort), 1.2 * effort).empty());
    CHECK_THAT(verdict("virtuose6d", at(number::kMaxSpeed), 0.9 * rate), Contains("speed limit" + of));
    CHECK(verdict("virtuose6d", at(number::kMaxSpeed), 10 * rate).empty());
  }
  const firmware::Config config = firmware_config(p, 1000);
  for (const auto& [address, expected] :
       {std::pair{number::kMaxForce, config.max_force_N}, std::pair{number::kMaxTorque, config.max_torque_Nm}}) {
    const double norm = static_cast<double>(expected);
    const char* what = address == number::kMaxForce ? "max_force" : "max_torque";
    CHECK_THAT(verdict("virtuose6d", address, 0.01), Contains(what) && Contains("is 0.00999"));
    CHECK_THAT(verdict("virtuose6d", address, 0.9 * norm), Contains(what));
    CHECK_THAT(verdict("virtuose6d", address, 1.6 * norm), Contains(what));
    CHECK(verdict("virtuose6d", address, 1.2 * norm).empty());
  }
  CHECK(verdict("desk3d", number::kMaxTorque, 0.0).empty());  // it has no such motors
  CHECK_THAT(verdict("virtuose6d", number::kQuantum, std::uint32_t{0x7fc00000}), Contains("quantum of axis 0 is nan"));
  CHECK_THAT(verdict("virtuose6d", number::kMaxEffort, std::uint32_t{0x7fc00000}), Contains("effort limit"));
  CHECK_THAT(verdict("virtuose6d", number::kMaxSpeed, std::uint32_t{0x7fc00000}), Contains("speed limit"));
  CHECK(verdict("desk3d", number::kQuantum + 4, 0.5).empty());  // an axis that is not there
}

TEST_CASE("a device that does not answer, or lacks a register, gives one line") {
  const DeviceProfile& profile = *find_profile("virtuose6d");
  SpoiltLink link(profile);
  link.spoilt = number::kMaxEffort + 2;
  link.silent = true;
  CHECK(check_identity(profile, 1000, link).message() == "link: no answer in time; is the device on?");
  link.silent = false;
  link.refuses = true;
  CHECK_THAT(check_identity(profile, 1000, link).message(), Contains("register 0x0112 is not there"));
}
