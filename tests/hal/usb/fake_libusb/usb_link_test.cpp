// The host's end of the USB link against a device whose endpoints halt and whose cable is pulled.
#include "hal/usb/usb_link.h"

#include <catch2/catch.hpp>
#include <thread>

#include "tests/hal/usb/fake_libusb/fake_libusb.h"

using namespace tactus;
using namespace tactus::hal;
using namespace tactus::test;
using Catch::Contains;

namespace {

// Until `holds`; the bound is for a test that fails.
template <class F>
bool soon(F&& holds) {
  for (int i = 0; i < 5'000; ++i) {
    if (holds()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

std::unique_ptr<UsbLink> opened() {
  auto link = UsbLink::open({.device = {}, .realtime = {.cpu = -1, .priority = 0}});
  INFO(link.message());
  REQUIRE(link.ok());
  return std::move(link).value();
}

bool states_flow() {
  const std::uint64_t before = fake_usb().states;
  return soon([&] { return fake_usb().states > before + 20; });
}

bool commands_flow(UsbLink& link) {
  const std::array<std::byte, firmware::kCommandFrameSize> command{};
  const std::uint64_t before = fake_usb().commands;
  return soon([&] {
    (void)link.send(command);
    return fake_usb().commands > before + 5;
  });
}

void check_nothing_freed_in_flight() {
  CHECK(fake_usb().freed_in_flight == 0);
  CHECK(fake_usb().closed_in_flight == 0);
}

}  // namespace

TEST_CASE("USB: endpoints that are halted when the link opens are cleared, and frames flow", "[threads]") {
  reset_fake_usb();
  change_fake_usb([](FakeUsb& usb) { usb.in_halted = usb.out_halted = true; });
  auto link = opened();
  CHECK(states_flow());
  CHECK(commands_flow(*link));
  CHECK(link->connected());
  CHECK(fake_usb().opened == 1);
  link.reset();
  check_nothing_freed_in_flight();
}

TEST_CASE("USB: an endpoint that halts while frames flow is cleared, without an end of the connection", "[threads]") {
  reset_fake_usb();
  auto link = opened();
  for (int round = 0; round < 10; ++round) {
    const bool in = round % 2 == 0;
    change_fake_usb([in](FakeUsb& usb) { (in ? usb.in_halted : usb.out_halted) = true; });
    REQUIRE(commands_flow(*link));
    REQUIRE(states_flow());
    REQUIRE(link->connected());
  }
  CHECK(fake_usb().opened == 1);
  CHECK(link->counters().disconnects == 0);
  CHECK(link->counters().errors >= 10);
  link.reset();
  check_nothing_freed_in_flight();
}

TEST_CASE("USB: an endpoint that halts again and again ends the connection, and the next one clears it", "[threads]") {
  reset_fake_usb();
  auto link = opened();
  REQUIRE(states_flow());
  change_fake_usb([](FakeUsb& usb) { usb.in_halted = usb.halts_again = true; });
  REQUIRE(soon([&] { return fake_usb().opened >= 3; }));
  change_fake_usb([](FakeUsb& usb) { usb.halts_again = false; });
  REQUIRE(soon([&] { return link->connected(); }));
  CHECK(states_flow());
  CHECK(commands_flow(*link));
  link.reset();
  check_nothing_freed_in_flight();
}

TEST_CASE("USB: a link may be closed at any moment of a halt, a lost device or a new connection", "[threads]") {
  for (int round = 0; round < 30; ++round) {
    reset_fake_usb();
    auto link = opened();
    change_fake_usb([round](FakeUsb& usb) {
      usb.in_halted = usb.halts_again = round % 3 != 0;
      usb.plugged = round % 3 != 0;
    });
    if (round % 3 == 0) {
      REQUIRE(soon([&] { return !link->connected(); }));
      change_fake_usb([](FakeUsb& usb) { usb.plugged = true; });
    }
    if (round % 3 == 2) REQUIRE(soon([&] { return fake_usb().opened > 1; }));
    link.reset();
    check_nothing_freed_in_flight();
  }
}

TEST_CASE("USB: a connection whose transfers are refused is closed and opened again", "[threads]") {
  reset_fake_usb();
  auto link = opened();
  change_fake_usb([](FakeUsb& usb) { usb.submit_fails = true; });
  REQUIRE(soon([&] { return fake_usb().opened >= 3; }));
  CHECK_FALSE(link->connected());
  change_fake_usb([](FakeUsb& usb) { usb.submit_fails = false; });
  REQUIRE(soon([&] { return link->connected(); }));
  CHECK(states_flow());
  link.reset();
  check_nothing_freed_in_flight();
}

TEST_CASE(
    "USB: another device in the place of the one that was pulled is refused by its serial, and not called unplugged",
    "[threads]") {
  reset_fake_usb();
  auto link = opened();
  change_fake_usb([](FakeUsb& usb) { usb.plugged = false; });
  REQUIRE(soon([&] { return !link->connected(); }));
  const auto question = [&] { return link->call({}, std::chrono::milliseconds(5)).message(); };
  REQUIRE(soon([&] { return question().find("plug it in") != std::string::npos; }));
  change_fake_usb([](FakeUsb& usb) {
    usb.plugged = true;
    usb.serial = "\x1b[2J";
  });
  REQUIRE(soon([&] { return question().find("serial A1; there are") != std::string::npos; }));
  CHECK_THAT(question(), Contains("\\x1b[2J") && !Contains("\x1b") && !Contains("unplugged"));
  CHECK_FALSE(link->connected());
  change_fake_usb([](FakeUsb& usb) { usb.serial = "A1"; });
  CHECK(soon([&] { return link->connected(); }));
}
