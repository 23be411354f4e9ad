// The common part of the classes whose devices speak firmware/PROTOCOL.md.
// Thread: [setup] and normal threads.
#pragma once

#include "hal/device_class.h"

namespace tactus::hal {

// Reads the identity of the device on `link` now. The returned function reads it again and compares; it must not
// outlive the link. Errors: one line.
Result<std::function<Status()>> remember_device(AnyLink& link);

// Compares the device on the link with its description and makes a device of both. Errors: one line.
Result<OpenedDevice> open_on_link(OpenedLink opened, const DeviceRequest& request);

// The `open` of a class whose `open_link` is the given function.
template <Result<OpenedLink> (*open_link)(const DeviceRequest&)>
Result<OpenedDevice> open_over(const DeviceRequest& request) {
  auto link = open_link(request);
  if (!link.ok()) return link.status();
  return open_on_link(std::move(link).value(), request);
}

}  // namespace tactus::hal
