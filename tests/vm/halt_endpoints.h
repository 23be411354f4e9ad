// Halts both endpoints of the device on USB from the host's side, as a program may that had it before. Not while a
// program has it.
#pragma once

#include <libusb.h>

#include "firmware/usb_interface.h"

namespace tactus::vm {

// Returns 0, or the error of libusb.
inline int halt_endpoints() {
  constexpr std::uint8_t kToEndpoint = 0x02, kSetFeature = 0x03;
  constexpr std::uint16_t kEndpointHalt = 0;
  libusb_context* context = nullptr;
  if (const int error = libusb_init(&context); error != 0) return error;
  libusb_device_handle* handle = libusb_open_device_with_vid_pid(context, firmware::kUsbVendor, firmware::kUsbProduct);
  int error = handle == nullptr ? static_cast<int>(LIBUSB_ERROR_NO_DEVICE) : 0;
  for (const auto endpoint : {firmware::kUsbStateEndpoint, firmware::kUsbCommandEndpoint})
    if (error == 0)
      error = libusb_control_transfer(handle, kToEndpoint, kSetFeature, kEndpointHalt, endpoint, nullptr, 0, 1000);
  if (handle != nullptr) libusb_close(handle);
  libusb_exit(context);
  return error < 0 ? error : 0;
}

}  // namespace tactus::vm
