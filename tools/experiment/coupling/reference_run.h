// What a coupling is measured against: the whole world at the haptic rate, the hand in the loop.
//
// The hand's motion of this run is what all the others are given, so that they differ by the coupling alone. Contact is
// chaotic, so the others are compared over short windows that each start from this run's state. Thread: one.
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
  std::vector<WorldKeyframe> before;  // one cycle earlier, in the order of the ratios asked for
};

struct ReferenceRun {
  std::vector<haptics::DeviceTarget> ideal, encoded;  // what an ideal and the device's own encoder say, by tick
  std::vector<Wrenchd> on_device;                     // by tick, N, N m, world
  std::vector<Vec3d> force;                           // of it, N
  std::vector<EnergySample> motion;                   // at the beginning of the tick
  std::vector<std::uint8_t> touches;                  // the proxy does
  std::vector<Window> windows;
  std::uint32_t most_points{0};  // contact points at once

  // Of the coupling on the proxy, over the `ticks` before a tick.
  Wrenchd mean_on_proxy(std::size_t tick, unsigned ticks) const;
};

struct WindowPlace {
  std::size_t start{0};
  bool hold{false};
};

inline constexpr double kHapticRate_Hz = 1000;
inline constexpr std::size_t kWindowTicks = 200;  // the least, for the spectrum

// A window is counted in cycles, so that every ratio has as many synchronisations: kWindowCycles of the ratio, but at
// least kWindowTicks. The hand's script has room for kLongestWindow: beyond ratio 16 there are fewer cycles.
inline constexpr std::size_t kWindowCycles = 25, kLongestWindow = 400;
std::size_t window_ticks(unsigned ratio);

std::size_t tick_at(double time_s);
// Where the windows are in the hand's script (coupling_cases.h): half of them while it holds.
std::vector<WindowPlace> window_places(bool quick);

ReferenceRun record_reference(CoupledWorlds& worlds, ScriptedArm& arm, std::size_t ticks,
                              std::span<const WindowPlace> places, std::span<const unsigned> ratios);

// The force on the device over `ticks`, tick by tick, from where the worlds were started. `energy`, when given, gets
// what all bodies have at the synchronisations.
std::vector<Vec3d> run_window(CoupledWorlds& worlds, const std::vector<haptics::DeviceTarget>& targets,
                              const ReferenceRun& reference, const Window& window, std::size_t ticks,
                              EnergyBook* energy);

}  // namespace tactus::experiment
