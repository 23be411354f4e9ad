// Detects a device that was commanded to exert force and does not. This is a fault at once, whatever the reason: if the
// force returned later, it would return as a step, because the coupling's stretch has changed meanwhile.
//
// A device that has accepted a command with FORCE is in FORCE, or in BRAKE, which the input guard handles. The sequence
// that it echoes shows which command it has. The first command of a sequence may only start the change, and the device
// may need a period for it; at the third accepted command without FORCE it counts as refusing. An intact sample counts
// here even if its sequence is old, as in the guard: stopping is safe, and a device that was reset restarts its
// sequence. Thread: [rt]. Bound: constant time. Faults: kDeviceLeftForce, kForceRefused. A device that echoes nothing
// is not watched.
#pragma once

#include <cstdint>
#include <type_traits>

#include "rt/base/status.h"
#include "rt/haptics/device.h"

namespace tactus::haptics {

inline constexpr std::uint32_t kRefusedCommands = 3;

struct ForceWatch {
  struct State {
    std::uint64_t first_sequence{0};    // first command that requests FORCE; 0: none
    std::uint64_t refused_sequence{0};  // newest command that the device accepted without being in FORCE
    std::uint32_t refused{0};           // number of such commands
    std::uint32_t in_force{0};          // 1: the device has been in FORCE since
  };
  State state;

  // FORCE is wanted from the command of this sequence on.
  void begin(std::uint64_t sequence) noexcept { state = {.first_sequence = sequence}; }
  void end() noexcept { state = {}; }

  // Call for each new sample. Returns the fault, or kNone.
  Fault watch(const DeviceSample& sample) noexcept {
    const bool heard = sample.echoed_sequence >= state.first_sequence;
    if (state.first_sequence == 0 || sample.state == DeviceState::kBrake) return Fault::kNone;
    if (sample.state == DeviceState::kForce) {
      if (heard) state.in_force = 1;
      return Fault::kNone;
    }
    if (state.in_force != 0) return Fault::kDeviceLeftForce;
    if (!heard || sample.echoed_sequence == state.refused_sequence) return Fault::kNone;
    state.refused_sequence = sample.echoed_sequence;
    return ++state.refused >= kRefusedCommands ? Fault::kForceRefused : Fault::kNone;
  }
};

static_assert(std::is_trivially_copyable_v<ForceWatch::State> && sizeof(ForceWatch::State) == 24);

}  // namespace tactus::haptics
