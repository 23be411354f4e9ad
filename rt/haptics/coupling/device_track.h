// Where the device is, for the global world: the report says so at each synchronisation, and the global step holds the
// proxy to it (DeviceLoad::kSpring).
//
// The interpolation coupling reports the mean velocity over the last cycle, and not that of the last tick: it carries
// less of the encoder's noise, and the loop with a light proxy bears up to twice the stiffness (interpolation_limit.h;
// tried with 0.01 to 2 kg at ratios 1 to 20).
// Thread: [rt], the haptic thread. Frame: world. Units: SI. Bound: constant time.
#pragma once

#include "rt/haptics/coupling/snapshot.h"

namespace tactus::haptics {

// Copied to the tape byte by byte: no padding.
struct DeviceTrack {
  Posed device;                    // where the last tick had the device at its end
  Twistd velocity;                 // in that tick
  Posed before;                    // `device` when the cycle began
  std::uint32_t engaged_ticks{0};  // without a break, up to the last tick; counts no further than 2^31
  std::uint32_t padding{0};

  // Once a tick: what the device did in it.
  void note(const DeviceTarget& target, double period_s) noexcept;
  // Where the device is now, and how fast in the last tick; not engaged: nothing.
  DeviceTarget latest() const noexcept {
    return engaged_ticks == 0 ? DeviceTarget{} : DeviceTarget{true, device, velocity};
  }
  // The same after a cycle of `ticks`, with the mean velocity over it; engaged for less than that: as `latest`.
  DeviceTarget over_cycle(std::uint32_t ticks, double period_s) const noexcept;
  // At a synchronisation, after the report.
  void begin_cycle() noexcept { before = device; }
};

static_assert(std::is_trivially_copyable_v<DeviceTrack>);

// That brings `from` to `to` in this time, about the centre.
inline Twistd mean_velocity(const Posed& from, const Posed& to, double time_s) noexcept {
  return {(to.position - from.position) * (1 / time_s),
          small_rotation_vector(to.rotation * conjugate(from.rotation)) * (1 / time_s)};
}

}  // namespace tactus::haptics
