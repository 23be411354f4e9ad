// The interpolation coupling: the device feels the proxy of the global world, interpolated between global states.
//
// Down: over a cycle the proxy that is felt goes evenly from its pose in G(n-1) to its pose in G(n), so it is one cycle
// behind the global world. Up: the effort on the proxy is the coupling's spring and damper between it and the device.
// The paper (section 3.3) stores that effort over the cycle and applies it all at once: an impulse that is up to three
// cycles old by the time it is felt, on a proxy of 0.1 kg; no gains that a hand can use are stable with it. Here the
// report says where the device is and how it moves (device_track.h), and the global step solves the same spring and
// damper implicitly with its contacts (physics::PoseSpring). What is left of the scheme's faults is its delay: the most
// stiffness that it bears falls with the ratio.
// Thread: [rt], the haptic thread. Frame: world. Units: SI. Bound: constant time. Raises no status.
// Source: the paper, section 3.3; the implicit spring: Colgate, Stanley, Brown 1995 (virtual coupling).
#pragma once

#include "rt/haptics/coupling/snapshot.h"

namespace tactus::haptics {

// Copied to the tape byte by byte: no padding.
struct ProxyInterpolation {
  physics::BodyMotion global_proxy[2];  // in G(n-1), in G(n)

  // At a synchronisation: `proxy` is that of G(n). With `first` nothing came before it.
  void adopt(const physics::BodyMotion& proxy, bool first) noexcept {
    global_proxy[0] = first ? proxy : global_proxy[1];
    global_proxy[1] = proxy;
  }
  // In tick `tick` of the cycle, 0 first: the proxy that the device feels. After the cycle it waits at its end.
  physics::BodyMotion in_tick(std::uint32_t tick, std::uint32_t ratio, double period_s) const noexcept;
};

static_assert(std::is_trivially_copyable_v<ProxyInterpolation>);

}  // namespace tactus::haptics
