// Parses `--device`: the simulated device, or a real one and its connection.
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
  std::string serial;     // usb; empty: that of the description, or the only device connected
  std::string interface;  // can, such as can0
  unsigned node{0};       // can: the device's node id; 0: the description's

  bool is_real() const noexcept { return kind != DeviceKind::kSimulated; }
};

// Error, one line: what was given and what is accepted.
Result<DeviceChoice> parse_device_choice(const std::string& text);

}  // namespace tactus::session
