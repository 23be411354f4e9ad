// Does a device that is told to give force give it? Whatever the reason, one that does not is a fault at once: its
// force would come back as a step, in a coupling that has moved on.
//
// A device that has accepted a command that wants FORCE is in FORCE, or in BRAKE, which the input guard sees. It says
// which command it has by the sequence that it echoes. The first command of a sequence may start it and do no more, and
// a device may need a period to change: at the third that it has accepted, not in FORCE, it refuses. An intact
// sample is believed here even when its sequence is old, as the guard does: to stop is safe, and a device that was
// reset begins its sequence anew. Thread: [rt]. Bound: constant time. Faults: kDeviceLeftForce, kForceRefused. A device
// that echoes nothing is not watched.
#pragma once

#include <cstdint>
#include <type_traits>

#include "rt/base/status.h"
#include "rt/haptics/device.h"

namespace tactus::haptics {

inline constexpr std::uint32_t kRefusedCommands = 3;

struct ForceWatch {
  struct State {
    std::uint64_t first_sequence{0};    // of the commands that want FORCE; 0: none does
    std::uint64_t refused_sequence{0};  // the newest that was accepted by a device that was not in FORCE
    std::uint32_t refused{0};           // how many
    std::uint32_t in_force{0};          // 1: the device has been in FORCE since
  };
  State state;

  // From the command of this sequence on FORCE is wanted.
  void begin(std::uint64_t sequence) noexcept { state = {.first_sequence = sequence}; }
  void end() noexcept { state = {}; }

  // Of each new sample.
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
