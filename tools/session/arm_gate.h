// Between those who ask for force, and the loop: a real device is compared with what the run began with before it is
// armed or re-armed.
//
// Thread: construction [setup]; pass() [rt], the haptic thread's: two atomic exchanges at most; look() normal, one
// thread: it asks the device and takes as long as that does. What the check refuses is dropped: ask again.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>

#include "rt/base/result.h"

namespace tactus::session {

// A device on a link is told to be IDLE for so many ticks before a run arms it: it gives no FORCE to a host that never
// wanted IDLE. Many, for some may be lost.
inline constexpr std::uint32_t kIdleTicks = 20;

class ArmGate {
 public:
  // `same_device`: null where nothing can change, as on the simulated device.
  explicit ArmGate(std::function<Status()> same_device) : same_device_(std::move(same_device)) {}

  // OperatorBit asked for in this tick: those that the loop is given now.
  std::uint32_t pass(std::uint32_t asked) noexcept;

  // Checks where somebody waits. The error: why the request was refused, in one line.
  Status look();

 private:
  std::function<Status()> same_device_;
  std::uint32_t unchecked_ticks_{kIdleTicks + 1};  // the first ones follow the check at the start
  std::atomic<std::uint32_t> waiting_{0}, granted_{0};
};

}  // namespace tactus::session
