// Which Falcon is opened, of those that are plugged in: it has no serial number, so the USB port says which.
#include <catch2/catch.hpp>

#include "hal/device_class.h"
#include "hal/falcon/falcon_usb.h"
#include "hal/usb/usb_port.h"
#include "tests/hal/usb/fake_libusb/fake_libusb.h"

using namespace tactus;
using namespace tactus::hal;
using namespace tactus::test;
using Catch::Contains;

namespace {

void plug_in(std::vector<FakeUsbPort> falcons) {
  reset_fake_usb();
  change_fake_usb([&](FakeUsb& usb) { usb.falcons = std::move(falcons); });
}

const FakeUsbPort kFirst{1, {2}}, kSecond{1, {3, 4}}, kOther{2, {2}};

}  // namespace

TEST_CASE("falcon: of two, the one at the USB port that is named is opened") {
  plug_in({kSecond, kFirst, kOther});
  for (const auto& [name, port] : {std::pair{"1-2", kFirst}, {"1-3.4", kSecond}, {"2-2", kOther}}) {
    CAPTURE(name);
    const auto opened = FalconUsb::open(name);
    REQUIRE(opened.ok());
    CHECK(fake_usb().falcon_opened == port);
    CHECK(opened.value()->port() == name);
  }
}

TEST_CASE("falcon: the only one needs no port, and has one") {
  plug_in({kSecond});
  const auto opened = FalconUsb::open();
  REQUIRE(opened.ok());
  CHECK(opened.value()->port() == "1-3.4");
}

TEST_CASE("falcon: two without a port, and a port without a Falcon, are refused with the ports that there are") {
  plug_in({kSecond, kFirst});
  CHECK_THAT(FalconUsb::open().message(),
             Contains("2 Falcons are plugged in, at the USB ports 1-2, 1-3.4") && Contains("falcon:@1-2"));
  CHECK_THAT(FalconUsb::open("1-3").message(), Contains("no Falcon is plugged into USB port 1-3") &&
                                                   Contains("accepted: where there is one: 1-2, 1-3.4"));
  CHECK(fake_usb().opened == 0);
  plug_in({});
  CHECK_THAT(FalconUsb::open("1-2").message(), Contains("no Falcon (0403:cb48) is plugged in"));
  plug_in({kFirst});
  change_fake_usb([](FakeUsb& usb) { usb.falcons_forbidden = true; });
  CHECK_THAT(FalconUsb::open("1-2").message(), Contains("udev rule"));
}

TEST_CASE("falcon: the port stands behind the firmware and the gain, and is what a hand takes") {
  const DeviceClass& falcon = *find_device_class("falcon");
  for (const char* address : {"@1-2", "image.bin@1-2", ",4000@1-2", "image.bin,4000@1-2", "/a@b/image.bin@1-2"}) {
    CAPTURE(address);
    CHECK(choose_device(std::string("falcon:") + address).ok());
    CHECK(falcon.takes(address, {}) == std::vector<std::string>{"USB port 1-2"});
  }
  CHECK(falcon.takes("/a@b/image.bin,4000", {}) == std::vector<std::string>{""});
  CHECK(falcon.force_gain("image.bin,4000@1-2") == 4000);
  CHECK(falcon.with_force_gain("image.bin@1-2.3", 5000) == "image.bin,5000@1-2.3");
  for (const char* address :
       {"@", "image.bin@", "@1", "@1-", "@-2", "@1-2.", "@1-2.x", "@1-2,4000", "image.bin@usb1"}) {
    CAPTURE(address);
    CHECK_THAT(choose_device(std::string("falcon:") + address).message(),
               Contains("behind the @, which is no USB port such as 1-2") && Contains("@USB-PORT"));
  }
}

TEST_CASE("a USB port is a bus, and the ports on the way") {
  for (const char* good : {"1-2", "12-1", "1-2.3", "3-1.4.2"}) CHECK(is_usb_port(good));
  for (const char* bad : {"", "1", "1-", "-1", "1-2.", "1-.2", "1-2-3", "1-2 ", "a-1", "1-2..3"})
    CHECK_FALSE(is_usb_port(bad));
}
