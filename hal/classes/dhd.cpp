// dhd[:FOLDER]: a Force Dimension device through the maker's library that its user has installed. Its properties are
// its own: a description has no effect.
#include "hal/device_class.h"
#include "hal/sdk/dhd_port.h"
#include "hal/sdk/sdk_device.h"

namespace tactus::hal {
namespace {

Status any_folder(std::string_view) { return Status::good(); }

Result<std::string> look(std::string_view address) {
  const auto library = DhdLibrary::load(address);
  if (!library.ok()) return library.status();
  return "Force Dimension's library is " + library.value()->path();
}

Result<OpenedDevice> open(const DeviceRequest& request) {
  auto library = DhdLibrary::load(request.address);
  if (!library.ok()) return library.status();
  auto port = DhdPort::open(std::move(library).value());
  if (!port.ok()) return port.status();
  std::string identity = port.value()->identity();
  auto device = SdkDevice::start(std::move(port).value(), request.period_ns);
  if (!device.ok()) return device.status();
  return OpenedDevice{std::make_unique<AnyDevice>(std::move(device).value()), std::move(identity), {}};
}

}  // namespace

extern const DeviceClass dhd_class;
const DeviceClass dhd_class{.name = "dhd",
                            .forms = "dhd, dhd:FOLDER",
                            .what = "a Force Dimension device, through the maker's library",
                            .real = true,
                            .check_address = any_folder,
                            .open = open,
                            .look = look};

}  // namespace tactus::hal
