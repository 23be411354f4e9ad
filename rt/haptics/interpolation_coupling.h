// The interpolation coupling: the device feels the proxy of the global world, interpolated between global states.
//
// Down: over a cycle the proxy that is felt goes evenly from its pose in G(n-1) to its pose in G(n), so it is one cycle
// behind the global world. Up: the effort on the proxy is the coupling's spring and damper between it and the device.
// The paper (section 3.3) stores that effort over the cycle and applies it all at once: an impulse that is up to three
// cycles old by the time it is felt, on a proxy of 0.1 kg; no gains that a hand can use are stable with it. Here the
// report says where the device is and how it moves, and the global step solves the same spring and damper implicitly
// with its contacts (physics::PoseSpring), the target going on with the device's mean velocity over the last cycle.
// The mean velocity, and not that of the last tick: it carries less of the encoder's noise, and the loop with a light
// proxy bears up to twice the stiffness (interpolation_limits.h; tried with 0.01 to 2 kg at ratios 1 to 20).
// What is left of the scheme's faults is its delay: the most stiffness that it bears falls with the ratio.
// Thread: [rt], the haptic thread. Frame: world. Units: SI. Bound: constant time. Raises no status.
// Source: the paper, section 3.3; the implicit spring: Colgate, Stanley, Brown 1995 (virtual coupling).
#pragma once

#include "rt/haptics/snapshot.h"

namespace tactus::haptics {

// Copied to the tape byte by byte: no padding.
struct InterpolationCoupling {
  physics::BodyMotion global_proxy[2];  // in G(n-1), in G(n)
  Posed device;                         // where the last tick had the device at its end, world
  Twistd device_velocity;               // in that tick, world
  Posed device_before;                  // `device` when the cycle began
  std::uint32_t engaged_ticks{0};       // without a break, up to the last tick; counts no further than 2^31
  std::uint32_t padding{0};

  // At a synchronisation: `proxy` is that of G(n). With `first` nothing came before it.
  void adopt(const physics::BodyMotion& proxy, bool first) noexcept;
  // At a synchronisation, before adopt: what the report says of the device after a cycle of `ticks`.
  DeviceTarget report(std::uint32_t ticks, double period_s) const noexcept;
  // Where the device is now, and how fast in the last tick.
  DeviceTarget latest() const noexcept {
    return engaged_ticks == 0 ? DeviceTarget{} : DeviceTarget{true, device, device_velocity};
  }
  // In tick `tick` of the cycle, 0 first: the proxy that the device feels. After the cycle it waits at its end.
  physics::BodyMotion proxy_in(std::uint32_t tick, std::uint32_t ratio, double period_s) const noexcept;
  // Once a tick: what the device did in it.
  void note(const DeviceTarget& target, double period_s) noexcept;
};

static_assert(std::is_trivially_copyable_v<InterpolationCoupling>);

}  // namespace tactus::haptics
