// The interpolation coupling: the device feels the proxy of the global world, interpolated between global states.
//
// Down: over a cycle the proxy that the device feels moves linearly from its pose in G(n-1) to its pose in G(n), so it
// lags the global world by one cycle. Up: the load on the proxy is the coupling's spring and damper between it and the
// device. The paper (section 3.3) accumulates that load over the cycle and applies it as one impulse. With a proxy of
// 0.1 kg that impulse is up to three cycles old when the hand feels its effect, and no gains of practical use are
// stable. Here the report contains the device's pose and velocity (device_track.h), and the global step solves the same
// spring and damper implicitly with its contacts (physics::PoseSpring). The scheme's remaining fault is its delay: the
// highest stable stiffness falls with the ratio.
// Thread: [rt], the haptic thread. Frame: world. Units: SI. Bound: constant time. Raises no status.
// Source: the paper, section 3.3; the implicit spring: Colgate, Stanley, Brown 1995 (virtual coupling).
#pragma once

#include "rt/haptics/coupling/snapshot.h"

namespace tactus::haptics {

// Copied to the tape byte by byte: no padding.
struct ProxyInterpolation {
  physics::BodyMotion global_proxy[2];  // in G(n-1), in G(n)

  // Call at a synchronisation; `proxy`: its motion in G(n). `first`: there is no earlier one.
  void adopt(const physics::BodyMotion& proxy, bool first) noexcept {
    global_proxy[0] = first ? proxy : global_proxy[1];
    global_proxy[1] = proxy;
  }
  // The interpolated proxy in tick `tick` of the cycle, from 0. Beyond the cycle: at rest at its pose in G(n).
  physics::BodyMotion in_tick(std::uint32_t tick, std::uint32_t ratio, double period_s) const noexcept;
};

static_assert(std::is_trivially_copyable_v<ProxyInterpolation>);

}  // namespace tactus::haptics
