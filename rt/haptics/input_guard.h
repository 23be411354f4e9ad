// Decides, before any arithmetic, whether a tick's device sample is valid, and what the loop uses instead if it is not.
//
// Checks, in this order: link status, the device's own state, sequence and device time advance, finite, quaternion
// norm, workspace, jump. Thread: accept(), rearm() [rt]. Frame: device. Units: SI; time is counted in ticks.
// Bound: constant time, no clock. Beyond the bounds:
//   - a tick without an accepted sample is *missed*: force_scale = 1 - missed / 10, never below 0, because the force
//     must fade when data is missing and must not be held; kForceFading from the third missed tick on;
//   - 10 missed: Fault kLinkLost (no intact frame) or kInputStale (frames whose sequence or time does not advance);
//   - 3 rejected samples without an accepted one between: the fault of the last rejection (kInputNotFinite,
//     kInputRotation, kInputWorkspace, kInputJump);
//   - at once: kDeviceUnplugged, kDeviceFault, kEmergencyStop, and kDeviceBrake once the device has been in FORCE.
// A fault latches until rearm(). From its first tick on every tick counts as missed, so the force is zero after 10.
#pragma once

#include <cstdint>
#include <type_traits>

#include "rt/base/status.h"
#include "rt/haptics/device.h"

namespace tactus::haptics {

inline constexpr std::uint32_t kFadingTicks = 3;    // missed ticks until the fade is reported
inline constexpr std::uint32_t kFadeOutTicks = 10;  // missed ticks until the force is zero, and until the link is lost
inline constexpr std::uint32_t kRejectedTicks = 3;  // consecutive rejected samples until their fault
inline constexpr std::uint32_t kExtrapolateTicks = 5;  // missed ticks over which the pose is extrapolated

struct GuardedInput {
  bool valid{false};       // a new sample was accepted in this tick
  bool rebased{false};     // valid and the first one after start or rearm(): clutch the placement to it
  Posed device_from_tool;  // m, unit quaternion: accepted, or extrapolated with decaying velocity, then held
  DeviceState device_state{DeviceState::kReset};  // of the newest intact frame
  std::uint32_t status{0};                        // StatusBit: kFrameMissing, kForceFading, kInputRejected, kNotArmed
  Fault fault{Fault::kNone};                      // latched, from the tick in which it occurs
  std::uint32_t missed{0};                        // consecutive ticks without an accepted sample
  double force_scale{0};                          // 0 to 1, for the force limiter
};

struct InputGuard {
  struct Config {
    double period_s{1e-3};
    DeviceProperties device;
    std::uint32_t emergency_stop_fault{0};           // the firmware's fault number of its e-stop line; 0: it has none
    std::uint32_t first_frame_ticks{kFadeOutTicks};  // time for the first frame after set-up; no force meanwhile
    std::uint32_t rearm_ticks{50};  // time for the device to leave BRAKE and clear its fault after rearm()
  };

  struct State {
    Posed last;       // last accepted pose: the reference of the jump check
    Posed reported;   // pose that accept() returned last
    Twistd velocity;  // m/s, rad/s: between the last two accepted samples
    std::uint64_t sequence{0}, device_time_ns{0};
    std::uint32_t missed{0}, rejected{0};
    std::uint32_t first_frame_left{0}, rearm_left{0};
    std::uint32_t based{0};         // 1: `last` holds a sample
    std::uint32_t started{0};       // 1: accept() was called
    std::uint32_t was_in_force{0};  // 1: the device has been in FORCE since start or rearm()
    std::uint32_t padding{0};
    DeviceState device_state{DeviceState::kReset};
    Fault fault{Fault::kNone};
  };

  Config config;
  State state;

  // [rt] Call once a tick. Raises the faults and bits above.
  GuardedInput accept(const DeviceInput& input) noexcept;
  // [rt] Clears the fault and the reference pose: the next good sample is accepted at any pose. A device that still
  // reports BRAKE or a fault has rearm_ticks to clear it; until then kNotArmed and no force.
  void rearm() noexcept;
};

static_assert(std::is_trivially_copyable_v<InputGuard::State> && std::is_trivially_copyable_v<GuardedInput>);
static_assert(sizeof(InputGuard::State) == 20 * 8 + 2 * 8 + 10 * 4, "no padding: the state goes to the tape");

}  // namespace tactus::haptics
