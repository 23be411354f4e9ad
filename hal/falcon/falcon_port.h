// The FTDI chip between the host and the Falcon: control requests and bytes. Real over libusb (falcon_usb.h), or a
// simulated device (simulated_falcon.h). Thread: one owner. Source: FTDI's application note AN232B-04 for the event
// character; the requests are those of the FT232 family.
#pragma once

#include <chrono>
#include <cstdint>
#include <span>

namespace tactus::hal {

enum class FtdiRequest : std::uint8_t {
  kReset = 0,    // value 1: flush what was received, 2: what waits to be sent
  kModem = 1,    // DTR 0x0101 / 0x0100, RTS 0x0202 / 0x0200
  kFlow = 2,     // 0: none
  kDivisor = 3,  // of 3 MHz: 0x4138 9600 bit/s, 0x15 142857, 0x02 1.5 Mbit/s
  kData = 4,     // 8: 8N1
  kEvent = 6,    // 0x0100 | character: its arrival sends what was received at once
  kLatency = 9,  // ms
};

class FalconPort {
 public:
  virtual ~FalconPort() = default;
  virtual bool control(FtdiRequest request, std::uint16_t value) noexcept = 0;  // false: the device is gone
  virtual bool write(std::span<const std::uint8_t> bytes) noexcept = 0;         // false: the device is gone
  // The bytes that came, without the chip's own; 0: none within the time, -1: the device is gone.
  virtual int read(std::span<std::uint8_t> bytes, std::chrono::milliseconds longest) noexcept = 0;
};

}  // namespace tactus::hal
