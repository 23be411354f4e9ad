// The device's pose and velocity for the report of a synchronisation. The global step couples the proxy to them
// (DeviceLoad::kSpring).
//
// The interpolation coupling reports the mean velocity over the last cycle instead of that of the last tick: it has
// less encoder noise, and the loop with a light proxy is stable up to twice the stiffness (interpolation_limit.h; tried
// with 0.01 to 2 kg at ratios 1 to 20).
// Thread: [rt], the haptic thread. Frame: world. Units: SI. Bound: constant time.
#pragma once

#include "rt/haptics/coupling/snapshot.h"

namespace tactus::haptics {

// Copied to the tape byte by byte: no padding.
struct DeviceTrack {
  Posed device;                    // pose predicted for the end of the last tick
  Twistd velocity;                 // in the last tick
  Posed before;                    // `device` when the cycle began
  std::uint32_t engaged_ticks{0};  // consecutive, up to the last tick; saturates at 2^31
  std::uint32_t padding{0};

  // Call once a tick, with the target of this tick.
  void note(const DeviceTarget& target, double period_s) noexcept;
  // Predicted pose and the velocity of the last tick; not engaged: a default target.
  DeviceTarget latest() const noexcept {
    return engaged_ticks == 0 ? DeviceTarget{} : DeviceTarget{true, device, velocity};
  }
  // The same with the mean velocity over a cycle of `ticks`; if engaged for less than the cycle: as `latest`.
  DeviceTarget over_cycle(std::uint32_t ticks, double period_s) const noexcept;
  // Call at a synchronisation, after the report.
  void begin_cycle() noexcept { before = device; }
};

static_assert(std::is_trivially_copyable_v<DeviceTrack>);

// Constant velocity [m/s, rad/s] that moves `from` to `to` in `time_s`, in the frame of the poses; angular: about the
// centre.
inline Twistd mean_velocity(const Posed& from, const Posed& to, double time_s) noexcept {
  return {(to.position - from.position) * (1 / time_s),
          small_rotation_vector(to.rotation * conjugate(from.rotation)) * (1 / time_s)};
}

}  // namespace tactus::haptics
