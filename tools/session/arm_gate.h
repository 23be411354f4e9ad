// Filters requests for force before they reach the loop: before a real device is armed or re-armed, its identity is
// compared with that at the start of the run.
//
// Thread: construction [setup]; pass() [rt], haptic thread, at most two atomic exchanges; look() on one normal thread:
// it queries the device and waits for the answer. A refused request is dropped and must be made again.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>

#include "rt/base/result.h"

namespace tactus::session {

// Number of ticks in which IDLE is commanded before a run arms a device on a link. The device enters FORCE only after
// the host has commanded IDLE. Repeated because frames may be lost.
inline constexpr std::uint32_t kIdleTicks = 20;

class ArmGate {
 public:
  // `same_device`: checks the identity; null if it cannot change, as on the simulated device.
  explicit ArmGate(std::function<Status()> same_device) : same_device_(std::move(same_device)) {}

  // `asked`: OperatorBits requested in this tick. Returns those that are passed on to the loop.
  std::uint32_t pass(std::uint32_t asked) noexcept;

  // Checks the device if a request is waiting. Error: why the request was refused, one line.
  Status look();

 private:
  std::function<Status()> same_device_;
  std::uint32_t unchecked_ticks_{kIdleTicks +
                                 1};  // the first ticks need no check: the start of the run has just made it
  std::atomic<std::uint32_t> waiting_{0}, granted_{0};
};

}  // namespace tactus::session
