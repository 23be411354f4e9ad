// The last stage before the device. For any input wrench the output is finite, within the device's force and torque
// limits, within the continuous rating of its motors, and limited in slew.
//
// Thread: limit() [rt]. Frame: any, the same for both. Units: SI. Force and torque are limited apart, each as a vector:
// its direction is kept. In this order:
//   1. not finite: zero, at once, and Fault kOutputNotFinite; no component of such a wrench is used;
//   2. saturation to the present limit L (kForceSaturated): L = peak while cool, towards continuous when warm;
//   3. the fade factor;
//   4. slew: at most `slew * T` from the last output (kSlewLimited). A falling fade is exempt: the last output is
//      first scaled by the ratio of this fade to the last one, so that the output is zero as soon as the fade is, for
//      any slew.
// Thermal: theta' = (|f|^2 - theta) / tau, a winding's temperature above ambient in N^2. L^2 goes from peak^2 at
// theta <= F_c^2 / 2 down to F_c^2 at theta = F_c^2, hence theta never exceeds F_c^2: the mean square over tau stays
// within the continuous rating, and a force within it is never cut. At F = 3 F_c from cold the cut begins after
// tau ln(18/17) = 1.7 s for tau = 30 s.
// Bound: |force| <= max_force_N and |torque| <= max_torque_Nm for the computed norms, exactly.
#pragma once

#include <cstdint>
#include <type_traits>

#include "rt/base/status.h"
#include "rt/haptics/device.h"

namespace tactus::haptics {

enum class Slew : std::uint32_t {
  kNormal = 0,
  kSlow = 1,  // engaging, a change of mode, recovery: gives the hand time to follow
};

struct ForceLimiter {
  // Force in N, torque in N m.
  struct PortConfig {
    double max{0};         // peak
    double continuous{0};  // allowed without a time limit
    double slew_per_s{0};  // N/s
    double slow_slew_per_s{0};
  };
  struct Config {
    double period_s{1e-3};
    double thermal_time_s{30};  // tau
    PortConfig force, torque;

    // 5000 N/s and 200 N/s: 5 N and 0.2 N a tick at 1 kHz. Torque in the ratio of the device's peaks.
    static Config of(const DeviceProperties& device, double period_s) noexcept;
  };
  struct Port {
    Vec3d last;      // sent last
    double heat{0};  // theta, N^2 or (N m)^2
  };
  struct State {
    Port force, torque;
    double last_fade{1};
  };
  struct Output {
    Wrenchd wrench;
    std::uint32_t status{0};
    Fault fault{Fault::kNone};
  };

  Config config;
  State state;

  // `fade`: 0 to 1; clamped to that range, NaN to 0.
  Output limit(const Wrenchd& wanted, double fade, Slew slew) noexcept;
  // The present saturation limit, N and N m.
  double force_limit_N() const noexcept;
  double torque_limit_Nm() const noexcept;
};

static_assert(std::is_trivially_copyable_v<ForceLimiter::State>);

}  // namespace tactus::haptics
