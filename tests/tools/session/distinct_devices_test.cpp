// Two hands cannot use the same device, interface or drive, whatever names they are given by.
#include "tools/session/distinct_devices.h"

#include <catch2/catch.hpp>

using namespace tactus;
using namespace tactus::session;
using Catch::Matchers::Contains;

namespace {

const std::string kArm = TACTUS_SOURCE_DIR "/hal/devices/point_arm_drives.toml";  // on can0

std::string refusal(const NamedDevice& first, const NamedDevice& second) {
  const NamedDevice devices[] = {first, second};
  const std::string message = check_distinct(devices, "virtuose6d").message();
  CHECK(message.find('\n') == std::string::npos);
  return message;
}

}  // namespace

TEST_CASE("devices of two hands that take the same are refused, by whatever name") {
  struct Case {
    NamedDevice first, second;
    const char* what;
  };
  const Case cases[] = {{{"drives", kArm}, {"drives:can0", kArm}, "takes can0, too"},
                        {{"drives:can1", kArm}, {"drives:can1", kArm}, "takes can1, too"},
                        {{"can:can0", {}}, {"can:can0:1", {}}, "takes can0 node 1, too"},
                        {{"usb", {}}, {"usb:A1", {}}, "takes A1, too"},
                        {{"usb", {}}, {"usb", {}}, "takes the first one there is, too"},
                        {{"dhd:/a", {}}, {"dhd:/b", {}}, "dhd:FOLDER,1234"},
                        {{"dhd:/a,7", {}}, {"dhd:/b,7", {}}, "takes serial 7, too"},
                        {{"falcon", {}}, {"falcon:image.bin", {}}, "falcon:@1-3 by the USB ports"},
                        {{"falcon:@1-2", {}}, {"falcon:image.bin,4000@1-2", {}}, "takes USB port 1-2, too"},
                        {{"falcon", {}}, {"falcon:@1-2", {}}, "takes USB port 1-2, too"},
                        {{"openhaptics", {}}, {"openhaptics:/a,Right", {}}, "one device of this library"}};
  for (const Case& c : cases) {
    CAPTURE(c.first.device, c.second.device);
    CHECK_THAT(refusal(c.first, c.second), Contains("--device " + c.second.device + ": serves one hand") &&
                                               Contains(c.first.device + " of hand 1") && Contains(c.what) &&
                                               Contains("accepted: "));
  }
}

TEST_CASE("devices of two hands that are two are accepted, and simulated ones as often as one likes") {
  const NamedDevice pairs[][2] = {{{"drives", kArm}, {"drives:can1", kArm}},
                                  {{"can:can0:1", {}}, {"can:can0:2", {}}},
                                  {{"usb:A1", {}}, {"usb:A2", {}}},
                                  {{"dhd:/a,7", {}}, {"dhd:/a,8", {}}},
                                  {{"falcon", {}}, {"usb", {}}},
                                  {{"falcon:@1-2", {}}, {"falcon:image.bin@1-2.1", {}}},
                                  {{"sim", {}}, {"sim", {}}},
                                  {{"drives-sim", kArm}, {"drives-sim", kArm}},
                                  {{"drives", "no such file"}, {"drives", "no such file"}}};
  for (const auto& pair : pairs) {
    CAPTURE(pair[0].device, pair[1].device);
    CHECK(refusal(pair[0], pair[1]).empty());
  }
}
