// The Falcon's FTDI chip over libusb. Thread: open() [setup]; the rest by one thread, which waits for the bus.
// Bound: a transfer waits for its own time-out, or kTransfer.
#pragma once

#include <memory>
#include <string>

#include "hal/falcon/falcon_port.h"
#include "rt/base/result.h"

struct libusb_context;
struct libusb_device_handle;

namespace tactus::hal {

class FalconUsb final : public FalconPort {
 public:
  static constexpr std::chrono::milliseconds kTransfer{200};
  static constexpr std::uint16_t kVendor = 0x0403, kProduct = 0xcb48;

  // `port`: the USB port that it is plugged into (usb_port.h); empty: the only one. Errors, one line: none there,
  // several and no port, no permission (with the udev rule), in use.
  static Result<std::unique_ptr<FalconUsb>> open(const std::string& port = {});
  ~FalconUsb() override;
  FalconUsb(const FalconUsb&) = delete;
  FalconUsb& operator=(const FalconUsb&) = delete;

  bool control(FtdiRequest request, std::uint16_t value) noexcept override;
  bool write(std::span<const std::uint8_t> bytes) noexcept override;
  int read(std::span<std::uint8_t> bytes, std::chrono::milliseconds longest) noexcept override;
  const std::string& port() const noexcept { return port_; }  // that it is plugged into

 private:
  FalconUsb() = default;
  Status choose(const std::string& port);
  libusb_context* context_{nullptr};
  libusb_device_handle* handle_{nullptr};
  std::string port_;
};

}  // namespace tactus::hal
