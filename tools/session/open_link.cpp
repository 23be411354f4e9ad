#include "tools/session/open_link.h"

#include <fmt/format.h>

#include "hal/can/can_link.h"
#include "hal/usb/usb_link.h"
#include "tools/session/device_file.h"

namespace tactus::session {
namespace {

Result<OpenedLink> open_usb(const DeviceChoice& choice, const hal::DeviceDescription& description) {
  hal::UsbOptions options;
  options.device.serial = choice.serial.empty() ? description.usb_serial : choice.serial;
  auto link = hal::UsbLink::open(options);
  if (!link.ok()) return Status::error("--device usb: " + link.message());
  std::string name = "USB, " + hal::describe(link.value()->info());
  return OpenedLink{std::make_unique<hal::AnyLink>(std::move(link).value()), std::move(name)};
}

Result<OpenedLink> open_can(const DeviceChoice& choice, const hal::DeviceDescription& description,
                            std::int64_t period_ns) {
  hal::CanOptions options;
  options.interface = choice.interface;
  options.node = static_cast<std::uint8_t>(choice.node != 0 ? choice.node : description.can_node);
  options.period = std::chrono::nanoseconds(period_ns);
  auto link = hal::CanLink::open(options);
  if (!link.ok()) return Status::error("--device can: " + link.message());
  std::string name = fmt::format("CAN {}, interface {}, node {}", link.value()->is_fd() ? "FD" : "classic",
                                 choice.interface, options.node);
  return OpenedLink{std::make_unique<hal::AnyLink>(std::move(link).value()), std::move(name)};
}

}  // namespace

Result<OpenedLink> open_link(const DeviceChoice& choice, const hal::DeviceDescription& description,
                             std::int64_t period_ns) {
  return choice.kind == DeviceKind::kUsb ? open_usb(choice, description) : open_can(choice, description, period_ns);
}

Result<hal::DeviceProfile> find_description(const std::string& profile_name, const std::filesystem::path& device_file) {
  if (!device_file.empty()) return load_device_file(device_file);
  const hal::DeviceProfile* profile = hal::find_profile(profile_name);
  if (profile == nullptr)
    return Status::error(fmt::format("--profile: '{}' is none; accepted: virtuose6d, desk3d", profile_name));
  return *profile;
}

}  // namespace tactus::session
