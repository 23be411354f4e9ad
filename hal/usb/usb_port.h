// The port that a USB device is plugged into, as the kernel names it: bus, and the ports on the way from its root hub,
// "1-2.4". It stays the same for as long as the device is not plugged in elsewhere. Thread: [setup].
#pragma once

#include <string>
#include <string_view>

struct libusb_device;

namespace tactus::hal {

std::string usb_port_of(libusb_device* device);

// BUS-PORT[.PORT]...: digits, as "1-2" or "3-1.4.2".
bool is_usb_port(std::string_view text) noexcept;

}  // namespace tactus::hal
