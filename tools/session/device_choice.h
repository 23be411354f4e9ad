// What `--device` names: the simulated device, or a real one and where it hangs.
//
//   sim   usb   usb:SERIAL   can:IFACE   can:IFACE:NODE
//
// Thread: normal.
#pragma once

#include <string>

#include "rt/base/result.h"

namespace tactus::session {

enum class DeviceKind { kSimulated, kUsb, kCan };

struct DeviceChoice {
  DeviceKind kind{DeviceKind::kSimulated};
  std::string serial;     // usb; empty: the one of the description, or the only one there is
  std::string interface;  // can, such as can0
  unsigned node{0};       // can: the device's node id; 0: the description's

  bool is_real() const noexcept { return kind != DeviceKind::kSimulated; }
};

// One line on anything else: what was given and what is accepted.
Result<DeviceChoice> parse_device_choice(const std::string& text);

}  // namespace tactus::session
