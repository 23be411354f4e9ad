// openhaptics[:FOLDER[,NAME]]: a 3D Systems Touch, Touch X or Phantom through the maker's library HD that its user has
// installed; NAME as the maker's setup program calls the device. Its properties are its own: a description has no
// effect.
#include "hal/classes/of_library.h"
#include "hal/device_class.h"
#include "hal/sdk/hd_port.h"
#include "hal/sdk/sdk_device.h"

namespace tactus::hal {
namespace {

struct HdAddress {
  std::string folder, name;
};

HdAddress parse(std::string_view address) {
  const std::size_t comma = address.rfind(',');
  if (comma == std::string_view::npos) return {std::string(address), {}};
  return {std::string(address.substr(0, comma)), std::string(address.substr(comma + 1))};
}

Status check_address(std::string_view address) {
  const bool unnamed = !address.empty() && address.back() == ',';
  return unnamed ? Status::error("names no device after the comma") : Status::good();
}

Result<std::string> look(std::string_view address) {
  const auto library = HdLibrary::load(parse(address).folder);
  if (!library.ok()) return library.status();
  return "3D Systems' library HD is " + library.value()->path();
}

Result<OpenedDevice> open(const DeviceRequest& request) {
  const HdAddress address = parse(request.address);
  auto library = HdLibrary::load(address.folder);
  if (!library.ok()) return library.status();
  auto port = HdPort::open(std::move(library).value(), address.name);
  if (!port.ok()) return port.status();
  std::string identity = port.value()->identity();
  auto device = SdkDevice::start(std::move(port).value(), request.period_ns);
  if (!device.ok()) return device.status();
  return opened_library(std::move(device).value(), std::move(identity));
}

}  // namespace

extern const DeviceClass openhaptics_class;
const DeviceClass openhaptics_class{.name = "openhaptics",
                                    .forms = "openhaptics, openhaptics:FOLDER, openhaptics:FOLDER,NAME",
                                    .what = "a 3D Systems Touch or Phantom, through the maker's library",
                                    .real = true,
                                    .check_address = check_address,
                                    .open = open,
                                    .takes = takes_the_only_one,
                                    .each_its_own = "one device of this library for a program",
                                    .describes_itself = true,
                                    .look = look};

}  // namespace tactus::hal
