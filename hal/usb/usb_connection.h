// Opens and claims one tactus device on USB; lists the connected ones.
//
// Each connection has its own libusb context, which scans the bus when it is created, with or without the udev daemon;
// so a replugged device is found by opening a new connection. Thread: [setup] and normal threads; none of it [rt].
// Bound: a scan of the bus, and up to 1 s for each device that does not return its serial number.
// Every error is one line that says what to do. Source: libusb 1.0 API; USB 2.0 chapter 9.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "firmware/usb_interface.h"
#include "rt/base/result.h"

struct libusb_context;
struct libusb_device_handle;

namespace tactus::hal {

struct UsbSelection {
  std::string serial;  // empty: the only connected device
  std::uint16_t vendor{firmware::kUsbVendor}, product{firmware::kUsbProduct};
};

struct UsbDeviceInfo {
  std::string serial;
  std::string port;                  // bus and port path, as the kernel names it: 1-2.4
  std::string speed;                 // "full", "high", ...
  std::uint16_t release{0};          // bcdDevice
  std::uint8_t protocol_version{0};  // 0: no tactus interface
  std::string problem;               // why it cannot be opened; empty: no problem
};

// "serial A1, port 1-2, high speed", and the problem if there is one.
std::string describe(const UsbDeviceInfo& info);

// The error of UsbConnection::open when no device of that vendor and product is connected.
Status no_usb_device(const UsbSelection& selection);

// All devices of that vendor and product, by port. Fails only if the bus itself cannot be scanned.
Result<std::vector<UsbDeviceInfo>> enumerate_usb(const UsbSelection& selection = {});

class UsbConnection {
 public:
  static Result<std::unique_ptr<UsbConnection>> open(const UsbSelection& selection);
  ~UsbConnection();
  UsbConnection(const UsbConnection&) = delete;
  UsbConnection& operator=(const UsbConnection&) = delete;

  libusb_context* context() const noexcept { return context_; }
  libusb_device_handle* handle() const noexcept { return handle_; }
  const UsbDeviceInfo& info() const noexcept { return info_; }
  std::uint8_t interface_number() const noexcept { return interface_; }
  std::uint8_t state_endpoint() const noexcept { return state_endpoint_; }
  std::uint8_t command_endpoint() const noexcept { return command_endpoint_; }

 private:
  UsbConnection() = default;
  Status find(const UsbSelection& selection);
  Status claim();

  libusb_context* context_{nullptr};
  libusb_device_handle* handle_{nullptr};
  UsbDeviceInfo info_;
  std::uint8_t interface_{0}, state_endpoint_{0}, command_endpoint_{0};
  bool claimed_{false};
};

}  // namespace tactus::hal
