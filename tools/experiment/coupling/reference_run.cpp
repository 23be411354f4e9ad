#include "tools/experiment/coupling/reference_run.h"

#include <algorithm>
#include <cmath>

#include "rt/base/status.h"

namespace tactus::experiment {

std::size_t tick_at(double time_s) { return static_cast<std::size_t>(std::llround(time_s * kHapticRate_Hz)); }

std::size_t window_ticks(unsigned ratio) { return std::clamp(kWindowCycles * ratio, kWindowTicks, kLongestWindow); }

std::vector<WindowPlace> window_places(bool quick) {
  if (quick) return {{tick_at(1.2), true}, {tick_at(2.05), false}};
  return {{tick_at(0.8), true},   {tick_at(1.05), true},   {tick_at(1.3), true},
          {tick_at(1.75), false}, {tick_at(1.975), false}, {tick_at(2.2), false}};
}

Wrenchd ReferenceRun::mean_on_proxy(std::size_t tick, unsigned ticks) const {
  Wrenchd sum;
  for (std::size_t k = tick - ticks; k < tick; ++k) sum -= on_device[k];
  return sum * (1.0 / ticks);
}

ReferenceRun record_reference(CoupledWorlds& worlds, ScriptedArm& arm, std::size_t ticks,
                              std::span<const WindowPlace> places, std::span<const unsigned> ratios) {
  ReferenceRun run;
  for (const WindowPlace& place : places) {
    run.windows.push_back({.start = place.start, .hold = place.hold, .now = {}, .before = {}});
    run.windows.back().before.resize(ratios.size());
  }
  worlds.start_at_rest();
  for (std::size_t k = 0; k < ticks; ++k) {
    if (k > 0) arm.advance(run.on_device.back());
    for (Window& window : run.windows) {
      if (k == window.start) window.now = worlds.keyframe(k, true);
      for (std::size_t i = 0; i < ratios.size(); ++i)
        if (k + ratios[i] == window.start) window.before[i] = worlds.keyframe(k, false);
    }
    run.motion.push_back(worlds.motion());
    run.ideal.push_back(arm.ideal());
    run.encoded.push_back(arm.encoded());
    const haptics::SubWorldStep& step = worlds.tick(run.ideal.back());
    run.on_device.push_back(step.on_device);
    run.force.push_back(step.on_device.force);
    run.touches.push_back((step.status & kProxyContact) != 0 ? 1 : 0);
    run.most_points = std::max(run.most_points, step.report.points);
  }
  return run;
}

std::vector<Vec3d> run_window(CoupledWorlds& worlds, const std::vector<haptics::DeviceTarget>& targets,
                              const ReferenceRun& reference, const Window& window, std::size_t ticks,
                              EnergyDeviation* energy) {
  std::vector<Vec3d> force;
  const double stiffness_N_per_m = worlds.sub_world().config().gains.stiffness_N_per_m;
  for (std::size_t k = window.start; k < window.start + ticks; ++k) {
    if (energy != nullptr && k > window.start && worlds.at_synchronisation())
      energy->add(worlds.motion(), reference.motion[k], 0.5 * norm_squared(reference.force[k]) / stiffness_N_per_m);
    force.push_back(worlds.tick(targets[k]).on_device.force);
  }
  if (energy != nullptr) energy->close_window();
  return force;
}

}  // namespace tactus::experiment
