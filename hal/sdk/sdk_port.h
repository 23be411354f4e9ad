// A maker's library, as a device on it sees it: one exchange, and the end of all force.
//
// Implementations call functions of a shared library that the user has installed; nothing of a maker is part of tactus.
// Thread: one owner, whose calls may wait for the bus. Frame: the device's. Units: SI.
#pragma once

#include "rt/haptics/device.h"

namespace tactus::hal {

enum class SdkResult : std::uint8_t {
  kFresh = 0,
  kOld = 1,    // the library gave the last sample once more
  kError = 2,  // it refused; the next exchange may succeed
  kGone = 3,   // the device is not there any more
};

struct SdkState {
  Posed device_from_tool;
  std::uint32_t buttons{0};
  bool may_push{true};  // false: the device has switched its forces off by itself
};

class SdkPort {
 public:
  virtual ~SdkPort() = default;
  virtual const haptics::DeviceProperties& properties() const noexcept = 0;
  // Sends a wrench and takes a state, in the order that the library wants.
  virtual SdkResult exchange(const Wrenchd& wrench, SdkState& state) noexcept = 0;
  virtual bool enable_forces(bool on) noexcept = 0;  // off: brakes, where the device has some. False: refused
};

}  // namespace tactus::hal
