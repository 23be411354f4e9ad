// Time-domain passivity at the device port: an observer that sums the energy that the hand and the virtual side
// exchange, and a controller that adds damping when the virtual side has given more than it got.
//
// Thread: control(), record_sent() [rt], once a tick each. Frame: one for both arguments (the loop: device). Units: SI.
// Wrenches are on the hand, as commanded to the device. Energy counts positive into the virtual side:
//   E_k = E_(k-1) - T f_(k-1-d).v_k    f: really sent (after all limits), v: over the interval just ended
// d: the transport delay in ticks, from a sample to the effort that answers it. The device holds f_(k-1-d) while it
// makes the motion v_k, on whichever path the delay lies. A sum without d takes a delayed spring for passive
// although it is not: a spring K with damping B supplies K (T/2 + t_d) |v|^2 and dissipates B |v|^2. For a fractional
// delay both wrenches are weighted by their share. Exact where v is the backward difference of the tool's pose and the
// hold starts with the tick.
// Translation and rotation have separate energy balances: a spring's energy must not pay for a torque.
// When E_k + D_k < 0 and |v| > v_eps:  f_k = f - alpha v_k,  alpha = min(alpha_max, -(E_k + D_k) / (T |v_k|^2)).
// D_k: what the damping that is sent and not yet felt will take if the hand keeps its speed; 0 without a delay. The
// damping counts when it is felt, so what alpha_max left unpaid stays in E as a debt for the next ticks.
// Bounds: alpha <= alpha_max, so the controller never kicks; E >= -debt_cap_J, the rest is forgiven (counted), so it
// never brakes for long; E <= energy_cap_J + what the coupling stored d ticks ago, which is what the hand can still get
// back; the rest is dropped (counted), so that an hour of dissipation cannot hide later activity. A delay beyond
// kMaxFeltLateTicks is taken as that. A passive virtual side gets back its own wrench, bit for bit.
// Sets kPassivityActive. Source: Hannaford, Ryu 2002, "Time-domain passivity control of haptic interfaces"; the exact
// balance for a held force: Ryu, Kim, Hannaford 2004.
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "rt/base/status.h"
#include "rt/haptics/coupling_limits.h"

namespace tactus::haptics {

// Energy that the coupling's springs hold now: 1/2 K e^2. The hand may take it back: it is not generated energy.
struct StoredEnergy {
  double translation_J{0}, rotation_J{0};
};

inline constexpr std::uint32_t kMaxFeltLateTicks = 32;  // the longest transport delay that a device may have

struct Passivity {
  struct PortConfig {
    double max_damping{0};  // alpha_max, N s/m or N m s/rad
    double min_speed{0};    // v_eps, m/s or rad/s: slower, alpha would follow the quantum and not the hand
    double energy_cap_J{0.05};
    double debt_cap_J{0.05};
  };
  struct Config {
    double period_s{1e-3};
    double felt_late_ticks{0};  // d; may lie between two ticks
    PortConfig translation, rotation;

    // alpha_max = the device's own damping + the coupling's, at the hand: what is stable at this rate anyhow.
    static Config of(const DeviceProperties& device, const CouplingGains& gains, double period_s) noexcept;
  };

  // What was sent in one tick.
  struct Sent {
    Vec3d wrench;        // N or N m: on the hand, held for a tick
    Vec3d damping;       // its part that the controller added
    double stored_J{0};  // by the coupling's springs in that tick
  };
  // One port's energy balance, J since the start. energy = in - out - dropped + forgiven.
  struct Port {
    std::array<Sent, kMaxFeltLateTicks + 2> sent;  // ring, newest at State::newest
    Vec3d damping;                                 // of this tick, not yet sent
    double stored_J{0};                            // of this tick
    double energy_J{0};                            // E
    double in_J{0}, out_J{0};                      // into the virtual side, out of it
    double dissipated_J{0};                        // by the controller's damping as requested, before the limits
    double dropped_J{0}, forgiven_J{0};            // beyond the energy cap, beyond the debt cap
    double alpha{0};                               // of this tick, N s/m or N m s/rad
  };
  struct State {
    Port translation, rotation;
    std::uint32_t newest{0}, padding{0};  // of both rings
  };

  Config config;
  State state;

  // Adds the energy of the interval just ended, then returns `wanted` plus the damping that is due. An argument that is
  // not finite adds nothing and returns `wanted` unchanged: the force limiter rejects it.
  Wrenchd control(const Wrenchd& wanted, const Twistd& tool_velocity, const StoredEnergy& stored = {}) noexcept;
  // Stores the wrench that was sent to the device in this tick: control() needs it when the device holds it.
  void record_sent(const Wrenchd& sent) noexcept;
  std::uint32_t status() const noexcept {
    return state.translation.alpha > 0 || state.rotation.alpha > 0 ? std::uint32_t{kPassivityActive} : 0u;
  }
};

static_assert(std::is_trivially_copyable_v<Passivity::State>);
static_assert(sizeof(Passivity::State) == 2 * ((kMaxFeltLateTicks + 2) * 56 + 24 + 8 * 8) + 8,
              "no padding: it goes to the tape");

}  // namespace tactus::haptics
