// The registry of device classes: what --device accepts, and that every class answers by the same rules.
#include "hal/device_class.h"

#include <catch2/catch.hpp>
#include <set>

#include "tests/hal/drives/drive_arms.h"

using namespace tactus;
using namespace tactus::hal;
using Catch::Matchers::Contains;

namespace {

DeviceChoice choice(const char* text) {
  const auto chosen = choose_device(text);
  INFO(text << ": " << chosen.message());
  REQUIRE(chosen.ok());
  return chosen.value();
}

Result<OpenedDevice> open(const DeviceClass& device_class, const DeviceProfile& profile) {
  return device_class.open({{}, profile, 1'000'000, {}, {}});
}

}  // namespace

TEST_CASE("the device option names a class, and where the class has one an address") {
  CHECK(choice("sim").device_class->name == "sim");
  CHECK_FALSE(choice("sim").device_class->real);
  CHECK(choice("usb").device_class->usb);
  CHECK(choice("usb").address.empty());
  CHECK(choice("usb:A1:7").address == "A1:7");
  CHECK(choice("can:can0").address == "can0");
  CHECK(choice("can:vcan12:127").address == "vcan12:127");
  CHECK(choice("can:vcan12:127").device_class->can_interfaces("vcan12:127") == std::vector<std::string>{"vcan12"});
  CHECK(choice("example").device_class->name == "example");
}

TEST_CASE("a device option with an unknown name gives one line with the accepted ones") {
  for (const char* text :
       {"", "usbx", "sim:1", "usb:", "can", "can:", "can::1", "can:can0:", "can:can0:0", "can:can0:128", "can:can0:1x",
        "can:can0:-1", "can:an_interface_of_16", "SIM", "example:2"}) {
    const auto chosen = choose_device(text);
    INFO(text);
    REQUIRE_FALSE(chosen.ok());
    CHECK_THAT(chosen.message(), Contains("--device: ") && Contains("accepted: sim, usb, usb:SERIAL, can:IFACE"));
    CHECK(chosen.message().find('\n') == std::string::npos);
  }
}

TEST_CASE("an arm of drives and a Falcon have addresses of their own") {
  CHECK(choice("drives").device_class->can_interfaces("").empty());
  CHECK(choice("drives:can0,vcan1").device_class->can_interfaces("can0,vcan1") ==
        std::vector<std::string>{"can0", "vcan1"});
  CHECK(choice("falcon:a,b.bin,4000").address == "a,b.bin,4000");
  for (const char* text :
       {"drives:", "drives:can0,", "drives:,can0", "drives:a,b,c", "drives:can0,can0", "drives-sim:can0",
        "falcon:x.bin,", "falcon:x.bin,12", "falcon:x.bin,1e9", "falcon:x.bin,4000x"}) {
    INFO(text);
    CHECK_THAT(choose_device(text).message(), Contains("--device: '") && Contains("accepted: "));
  }
}

TEST_CASE("what a class opens must be described: drives that are not are refused, and a bus that is too full") {
  const DeviceClass& drives = *find_device_class("drives-sim");
  CHECK_THAT(open(drives, *find_profile("desk3d")).message(), Contains("has no drives") && Contains("--device-file"));
  const DeviceProfile profile = test::drive_profile(test::point_arm_of(DriveFamily::kDamiao));
  CHECK_THAT(drives.open({{}, profile, 500'000, {}, {}}).message(), Contains("162 %") && Contains("--rate 1111"));
}

TEST_CASE("every class has a name of its own, its forms begin with it, and it can be found and opened by it") {
  std::set<std::string_view> names;
  for (const DeviceClass* device_class : device_classes()) {
    CAPTURE(device_class->name);
    CHECK(names.insert(device_class->name).second);
    CHECK(device_class->forms.starts_with(device_class->name));
    CHECK_FALSE(device_class->what.empty());
    CHECK(described_devices().find(std::string(device_class->forms) + ": " + std::string(device_class->what)) !=
          std::string::npos);
    CHECK(find_device_class(device_class->name) == device_class);
    REQUIRE(device_class->check_address != nullptr);
    REQUIRE(device_class->open != nullptr);
  }
  CHECK(find_device_class("none") == nullptr);
}

TEST_CASE("a class without hardware opens anywhere, and its device answers") {
  const DeviceProfile& desk = *find_profile("desk3d");
  for (const DeviceClass* device_class : device_classes()) {
    if (device_class->real) continue;
    CAPTURE(device_class->name);
    const bool of_drives = device_class->name == "drives-sim";
    auto opened = open(*device_class, of_drives ? test::drive_profile(test::point_arm_of(DriveFamily::kDamiao)) : desk);
    INFO(opened.message());
    REQUIRE(opened.ok());
    haptics::DeviceInput input;
    opened.value().device->read(input);
    CHECK(input.status == haptics::ReadStatus::kFresh);
  }
}

TEST_CASE("the simulated device is the one that the description describes") {
  DeviceDescription d = find_profile("desk3d")->description;
  d.peak_force_N = 6.5;
  auto opened = open(*find_device_class("sim"), make_profile(d));
  REQUIRE(opened.ok());
  CHECK(opened.value().device->properties().max_force_N == 6.5);
}
