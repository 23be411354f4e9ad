// What can be said of CAN interfaces without one: the rest is tests/vm/can_link_guest_test.cpp.
#include "hal/can/can_interface.h"

#include <catch2/catch.hpp>

#include "hal/can/can_link.h"

using namespace tactus::hal;
using Catch::Contains;
using namespace std::chrono_literals;

namespace {

CanInterface good() {
  CanInterface interface;
  interface.name = "can0";
  interface.is_can = interface.up = true;
  interface.controller = CanInterface::Controller::kActive;
  interface.bit_per_s = 1'000'000;
  interface.restart_ms = 100;
  return interface;
}

}  // namespace

TEST_CASE("an interface that is up at 1 Mbit/s carries classic frames, and FD frames only with their MTU") {
  CanInterface interface = good();
  CHECK(check_can_interface(interface, false).ok());
  CHECK_THAT(check_can_interface(interface, true).message(), Contains("fd on"));
  interface.fd = true;
  CHECK(check_can_interface(interface, true).ok());
  interface.is_virtual = true;
  interface.fd = false;
  CHECK_THAT(check_can_interface(interface, true).message(), Contains("mtu 72"));
}

TEST_CASE("an interface that is no CAN, down, or bus-off for good is refused with its remedy") {
  CanInterface interface = good();
  interface.is_can = false;
  CHECK_THAT(check_can_interface(interface, false).message(), Contains("can0 is no CAN interface"));

  interface = good();
  interface.up = false;
  CHECK_THAT(check_can_interface(interface, false).message(), Contains("ip link set can0 up") && !Contains("bitrate"));
  interface.bit_per_s = 0;
  CHECK_THAT(check_can_interface(interface, false).message(), Contains("ip link set can0 up type can bitrate 1000000"));

  interface = good();
  interface.controller = CanInterface::Controller::kBusOff;
  CHECK(check_can_interface(interface, false).ok());  // it restarts by itself
  interface.restart_ms = 0;
  CHECK_THAT(check_can_interface(interface, false).message(), Contains("bus-off") && Contains("restart-ms 100"));
}

TEST_CASE("a bit rate is refused from the period on that its frames do not fit into, stuffed at worst") {
  CanInterface interface = good();
  // 5.1 frames of 135 bits.
  CHECK(check_can_rate(interface, false, 688500ns).ok());
  CHECK_THAT(check_can_rate(interface, false, 688499ns).message(), Contains("1000000 bit/s") && Contains("--rate"));
  interface.bit_per_s = 500'000;
  CHECK_FALSE(check_can_rate(interface, false, 1ms).ok());
  CHECK(check_can_rate(interface, false, 1377us).ok());
  // FD: 66 slow bits and 1198 fast ones.
  interface.bit_per_s = 1'000'000;
  interface.data_bit_per_s = 5'000'000;
  interface.fd = true;
  CHECK(check_can_rate(interface, true, 305600ns).ok());
  CHECK_FALSE(check_can_rate(interface, true, 305599ns).ok());
  interface.data_bit_per_s = 0;  // FD frames without a faster part
  CHECK(check_can_rate(interface, true, 1264us).ok());
  CHECK_FALSE(check_can_rate(interface, true, 1263us).ok());
  interface.bit_per_s = 0;  // a virtual one has none
  CHECK(check_can_rate(interface, true, 1us).ok());
}

TEST_CASE("the kernel's own answer is understood") {
  const auto loopback = find_can_interface("lo");
  REQUIRE(loopback.ok());
  CHECK((!loopback.value().is_can && loopback.value().bit_per_s == 0));
  const auto none = find_can_interface("can-not-there");
  REQUIRE_FALSE(none.ok());
  CHECK_THAT(none.message(), Contains("no interface 'can-not-there'"));
}

TEST_CASE("options that make no sense are refused before anything is opened") {
  CHECK_THAT(CanLink::open({.node = 0}).message(), Contains("accepted: 1 to 127"));
  CHECK_THAT(CanLink::open({.node = 128}).message(), Contains("accepted: 1 to 127"));
  CHECK_THAT(CanLink::open({.period = 1ms, .wait = 2ms}).message(), Contains("wait"));
  CHECK_THAT(CanLink::open({.wait = -1ns}).message(), Contains("wait"));
  CHECK_THAT(CanLink::open({.interface = "lo"}).message(), Contains("no CAN interface"));
}
