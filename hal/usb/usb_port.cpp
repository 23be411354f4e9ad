#include "hal/usb/usb_port.h"

#include <fmt/format.h>
#include <libusb.h>

#include <algorithm>
#include <array>

namespace tactus::hal {

std::string usb_port_of(libusb_device* device) {
  std::array<std::uint8_t, 8> ports{};
  const int count = libusb_get_port_numbers(device, ports.data(), static_cast<int>(ports.size()));
  return fmt::format("{}-{}", libusb_get_bus_number(device),
                     fmt::join(ports.begin(), ports.begin() + std::max(count, 0), "."));
}

bool is_usb_port(std::string_view text) noexcept {
  const auto take_number = [&text] {
    const std::size_t end = std::min(text.find_first_not_of("0123456789"), text.size());
    text.remove_prefix(end);
    return end > 0;
  };
  const auto take = [&text](char one) {
    const bool is_there = text.starts_with(one);
    if (is_there) text.remove_prefix(1);
    return is_there;
  };
  if (!take_number() || !take('-') || !take_number()) return false;
  while (take('.'))
    if (!take_number()) return false;
  return text.empty();
}

}  // namespace tactus::hal
