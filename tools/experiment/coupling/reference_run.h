// Reference run of the coupling experiments: the whole world at the haptic rate, the hand in the loop.
//
// All other runs use the hand motion of this run, so that they differ only in the coupling. Contact is chaotic, so they
// are compared over short windows that each start from this run's state. Thread: one.
#pragma once

#include <span>
#include <vector>

#include "tools/experiment/coupling/coupled_worlds.h"
#include "tools/experiment/coupling/energy_measures.h"
#include "tools/experiment/coupling/scripted_arm.h"

namespace tactus::experiment {

struct Window {
  std::size_t start{0};  // tick
  bool hold{false};      // the hand's target stands still
  WorldKeyframe now;
  std::vector<WorldKeyframe> before;  // one cycle earlier, in the order of the requested ratios
};

struct ReferenceRun {
  std::vector<haptics::DeviceTarget> ideal, encoded;  // target by an ideal encoder and by the device's encoder, by tick
  std::vector<Wrenchd> on_device;                     // by tick, N, N m, world
  std::vector<Vec3d> force;                           // of it, N
  std::vector<EnergySample> motion;                   // at the beginning of the tick
  std::vector<std::uint8_t> touches;                  // the proxy does
  std::vector<Window> windows;
  std::uint32_t most_points{0};  // largest number of contact points at one time

  // Mean wrench of the coupling on the proxy, over the `ticks` before a tick.
  Wrenchd mean_on_proxy(std::size_t tick, unsigned ticks) const;
};

struct WindowPlace {
  std::size_t start{0};
  bool hold{false};
};

inline constexpr double kHapticRate_Hz = 1000;
inline constexpr std::size_t kWindowTicks = 200;  // the least, for the spectrum

// A window has kWindowCycles cycles, so that every ratio has as many synchronisations, but at least kWindowTicks. The
// hand's script allows kLongestWindow, so above ratio 16 there are fewer cycles.
inline constexpr std::size_t kWindowCycles = 25, kLongestWindow = 400;
std::size_t window_ticks(unsigned ratio);

std::size_t tick_at(double time_s);
// Positions of the windows in the hand's script (coupling_cases.h); half of them while it holds.
std::vector<WindowPlace> window_places(bool quick);

ReferenceRun record_reference(CoupledWorlds& worlds, ScriptedArm& arm, std::size_t ticks,
                              std::span<const WindowPlace> places, std::span<const unsigned> ratios);

// The force on the device over `ticks`, tick by tick, from the state in which the worlds were started. `energy`, if
// given, receives the energy of all bodies at the synchronisations.
std::vector<Vec3d> run_window(CoupledWorlds& worlds, const std::vector<haptics::DeviceTarget>& targets,
                              const ReferenceRun& reference, const Window& window, std::size_t ticks,
                              EnergyDeviation* energy);

}  // namespace tactus::experiment
