// usb[:SERIAL]: a device that speaks firmware/PROTOCOL.md over USB.
#include "hal/classes/on_link.h"
#include "hal/usb/usb_link.h"

namespace tactus::hal {
namespace {

Status check_address(std::string_view) { return Status::good(); }  // any text is a serial number

Result<OpenedLink> open_link(const DeviceRequest& request) {
  UsbOptions options;
  options.device.serial = request.address.empty() ? request.profile.description.usb_serial : request.address;
  auto link = UsbLink::open(options);
  if (!link.ok()) return Status::error("--device usb: " + link.message());
  std::string name = "USB, " + describe(link.value()->info());
  return OpenedLink{std::make_unique<AnyLink>(std::move(link).value()), std::move(name)};
}

std::vector<std::string> takes(std::string_view address, const DeviceDescription& description) {
  return {address.empty() ? description.usb_serial : std::string(address)};
}

}  // namespace

extern const DeviceClass usb_class;
const DeviceClass usb_class{.name = "usb",
                            .forms = "usb, usb:SERIAL",
                            .what = "a device with tactus' firmware or wire protocol, on USB",
                            .real = true,
                            .check_address = check_address,
                            .open = open_over<open_link>,
                            .open_link = open_link,
                            .takes = takes,
                            .each_its_own = "such as usb:SERIAL, or sim",
                            .usb = true};

}  // namespace tactus::hal
