// What can be seen without a device; both ends together are in tests/vm/usb_link_guest_test.cpp.
#include "hal/usb/usb_connection.h"

#include <catch2/catch.hpp>

#include "hal/usb/usb_link.h"

using namespace tactus;
using namespace tactus::hal;

namespace {

// Nobody's numbers.
UsbSelection nobody() { return {{}, 0xffff, 0xfffe}; }

}  // namespace

TEST_CASE("USB: a device is described by serial, port and speed, and by what is wrong with it", "[hal]") {
  UsbDeviceInfo info{
      .serial = "A1", .port = "1-2.4", .speed = "high", .release = 0x0100, .protocol_version = 1, .problem = {}};
  CHECK(describe(info) == "serial A1, port 1-2.4, high speed");
  info.serial.clear();
  info.problem = "no permission";
  CHECK(describe(info) == "serial unknown, port 1-2.4, high speed (no permission)");
}

TEST_CASE("USB: where no device is, opening one is an error of one line that names its numbers", "[hal][threads]") {
  const auto link = UsbLink::open({.device = nobody()});
  REQUIRE_FALSE(link.ok());
  // A system without any USB is an error too, of libusb's.
  const bool told = link.message().find("ffff:fffe") != std::string::npos ||
                    link.message().find("libusb does not start") != std::string::npos;
  INFO(link.message());
  CHECK(told);
  CHECK(link.message().find('\n') == std::string::npos);
}

TEST_CASE("USB: where no device is, the list is empty or says why there is none", "[hal][threads]") {
  const auto list = enumerate_usb(nobody());
  if (list.ok()) {
    CHECK(list.value().empty());
  } else {
    CHECK_FALSE(list.message().empty());
  }
}
