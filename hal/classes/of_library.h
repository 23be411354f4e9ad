// What the classes of devices through a maker's library have in common. Thread: [setup].
#pragma once

#include <memory>
#include <string>

#include "hal/device_class.h"
#include "hal/sdk/sdk_device.h"

namespace tactus::hal {

inline OpenedDevice opened_library(std::unique_ptr<SdkDevice> device, std::string identity) {
  const SdkDevice& library = *device;  // as long as `opened.device` lives
  OpenedDevice opened{.device = nullptr, .identity = std::move(identity)};
  opened.not_checked = {
      {"round-trip",
       "the echo says that the library has the command; when the device has it, the library does not tell"},
      {"watchdog", "what brakes here is tactus' own side of the library; " + library.watchdog()}};
  opened.trouble = [&library] { return library.trouble(); };
  opened.device = std::make_unique<AnyDevice>(std::move(device));
  return opened;
}

}  // namespace tactus::hal
