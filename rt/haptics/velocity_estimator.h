// The tool's velocity from its sampled, quantised poses: first-order adaptive windowing, end-fit.
//
// Thread: update(), reset() [rt]. Frame: device (linear: of the tool's origin; angular: in device axes). Units: SI.
// Bound: constant time, at most kMaxVelocityWindow^2 / 2 comparisons per axis.
// Per axis, with s_i = x_k - x_(k-i): the estimate is s_n / (n T) for the longest window n <= N such that every longer
// window up to it keeps all its samples within one quantum of the straight line through its two ends,
// |s_i - (i / n) s_n| <= quantum. Why one quantum: a sample is off by at most half a quantum, and so are the line's
// ends, hence a motion of constant velocity never breaks the test: its window grows to N and the error falls to
// quantum / (N T). A real change of velocity does break it, and the window shortens to what is still straight.
// The window is kept short because a long one is a delay, and a delay in a damper makes limit cycles at rest.
// Stiction band: an axis that has not moved half a quantum for `stiction_s` is at rest, exactly.
// Rotation: the same on the rotation vectors between successive quaternions, summed backwards from now.
// Source: Janabi-Sharifi, Hayward, Chen 2000, "Discrete-time adaptive windowing for velocity estimation".
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "rt/haptics/device.h"

namespace tactus::haptics {

inline constexpr std::uint32_t kMaxVelocityWindow = 16;

struct VelocityEstimator {
  struct Config {
    double period_s{1e-3};
    double position_quantum_m{1e-5}, rotation_quantum_rad{1e-4};
    std::uint32_t window{8};  // N: 1 to kMaxVelocityWindow, clamped
    double stiction_s{0.02};

    // Window 8 at 1 kHz, 16 at 4 kHz: noise falls with N T, so N grows with the root of the rate only.
    static Config of(const DeviceProperties& device, double period_s) noexcept;
  };

  struct Axes {
    std::array<Vec3d, kMaxVelocityWindow> steps;  // ring: motion over each tick, m or rad
    Vec3d since_change;                           // m or rad, since the axis last counted as moved
    std::array<std::uint32_t, 3> still{};         // ticks since then
    std::uint32_t padding{0};
  };
  struct State {
    Axes linear, angular;
    Posed last;
    std::uint32_t newest{0}, count{0};  // of both rings
    std::uint32_t started{0}, padding{0};
  };

  Config config;
  State state;

  // Call once a tick, with the guarded pose. Returns the tool's velocity [m/s, rad/s], device frame.
  Twistd update(const Posed& device_from_tool) noexcept;
  // Resets: the next pose starts at rest. Call after a rearm, where the pose may be anywhere.
  void reset() noexcept { state = State{}; }
};

static_assert(std::is_trivially_copyable_v<VelocityEstimator::State>);
static_assert(sizeof(VelocityEstimator::State) == 2 * (16 * 24 + 24 + 16) + 56 + 16, "no padding: it goes to the tape");

}  // namespace tactus::haptics
