// Interface to a maker's library: one call exchanges a wrench for a state, another switches the forces on or off.
//
// Implementations call functions of a shared library that the user has installed; nothing of a maker is part of tactus.
// Thread: one owner, whose calls may wait for the bus. Frame: the device's. Units: SI.
#pragma once

#include <string>

#include "rt/base/result.h"
#include "rt/haptics/device.h"

namespace tactus::hal {

enum class SdkResult : std::uint8_t {
  kFresh = 0,
  kOld = 1,    // the library returned the last sample again
  kError = 2,  // it refused; the next exchange may succeed
  kGone = 3,   // the device is not there any more
};

struct SdkState {
  Posed device_from_tool;
  std::uint32_t buttons{0};
  std::uint32_t fault{0};  // why the device gives no force: firmware/faults.h, sdk_faults.h; 0: no fault
};

// Called once a period.
struct SdkCall {
  void (*function)(void* context) noexcept {nullptr};
  void* context{nullptr};
};

class SdkPort {
 public:
  virtual ~SdkPort() = default;
  virtual const haptics::DeviceProperties& properties() const noexcept = 0;
  // Sends a wrench and takes a state, in the order that the library requires. The fault counts whatever the result is.
  virtual SdkResult exchange(const Wrenchd& wrench, SdkState& state) noexcept = 0;
  virtual bool enable_forces(bool on) noexcept = 0;  // off: also engages brakes, if the device has any. False: refused
  // Names what ends the force when this program or its library stops; a part of a line.
  virtual std::string watchdog() const = 0;

  // A library that makes its exchanges on a thread of its own has a scheduler: `call` runs there, once a period, from
  // start_calls() to the end of stop_calls(); exchange() and enable_forces() are then called in it. Others are called
  // by a thread of their device's.
  virtual bool has_scheduler() const noexcept { return false; }
  virtual Status start_calls(const SdkCall&, std::int64_t /*period_ns*/) { return Status::good(); }
  virtual void stop_calls() noexcept {}
};

}  // namespace tactus::hal
