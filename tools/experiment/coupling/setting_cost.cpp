#include "tools/experiment/coupling/setting_cost.h"

#include <algorithm>

#include "sim/model/step_settings.h"
#include "tools/session/session.h"

namespace tactus::experiment {
namespace {

// Of the reference run.
constexpr unsigned kReferenceSubSteps = 16, kReferenceRelaxSweeps = 2;

// A window, timed part by part.
std::vector<Vec3d> timed_window(CoupledWorlds& worlds, const ReferenceRun& reference, const Window& window,
                                std::size_t ticks, SettingSums& sums) {
  std::vector<Vec3d> force;
  const double stiffness_N_per_m = worlds.sub_world().config().gains.stiffness_N_per_m;
  for (std::size_t k = window.start; k < window.start + ticks; ++k) {
    if (!window.hold && k > window.start && worlds.at_synchronisation())
      sums.energy.add(worlds.motion(), reference.motion[k], 0.5 * norm_squared(reference.force[k]) / stiffness_N_per_m);
    sums.ticks_us.push_back(timed_tick_us(worlds, reference.ideal[k],
                                          [&] { sums.global_us.push_back(cpu_time_us([&] { worlds.serve(); })); }));
    force.push_back(worlds.last().on_device.force);
  }
  sums.energy.close_window();
  return force;
}

}  // namespace

void SettingSums::add(const SettingSums& other) {
  const auto append = [](std::vector<double>& to, const std::vector<double>& from) {
    to.insert(to.end(), from.begin(), from.end());
  };
  error.add(other.error);
  energy.add(other.energy);
  append(vibration, other.vibration);
  append(steps, other.steps);
  append(ticks_us, other.ticks_us);
  append(global_us, other.global_us);
}

sim::Scene with(sim::Scene scene, const CostSetting& setting) {
  scene.solver.sub_steps = setting.sub_steps;
  scene.solver.relax_sweeps = setting.relax_sweeps;
  scene.solver.friction_sweeps = setting.friction;
  scene.solver.contact_hertz = setting.contact_Hz;
  scene.solver.global_sub_steps_per_tick = std::max<double>(
      scene.solver.global_sub_steps_per_tick, sim::least_sub_steps(setting.contact_Hz, 1 / kHapticRate_Hz));
  return scene;
}

session::RunOptions options_of(const CostSetting& setting) {
  session::RunOptions options;
  setting.scheme.set(options);
  options.order = setting.order;
  options.world_precision = setting.precision;
  options.members = setting.members;
  options.rate_Hz = kHapticRate_Hz;
  return options;
}

ReferenceRun record_fine(const sim::Scene& scene, const hal::DeviceProfile& profile, std::size_t ticks,
                         std::span<const WindowPlace> places, std::span<const unsigned> ratios) {
  sim::Scene fine = scene;
  fine.solver.sub_steps = kReferenceSubSteps;
  fine.solver.relax_sweeps = kReferenceRelaxSweeps;
  auto options = options_of({});
  kDirectScheme.set(options);
  CoupledWorlds direct(fine, options, profile.properties);
  const auto config = session::loop_config(fine, options, profile.properties);
  ScriptedArm arm(profile, session::make_hand(fine), config.placement, config.period_s);
  return record_reference(direct, arm, ticks, places, ratios);
}

void measure_setting(const sim::Scene& scene, const hal::DeviceProfile& profile, const CostSetting& setting,
                     const ReferenceRun& reference, std::span<const unsigned> ratios, SettingSums& sums) {
  const sim::Scene solved = with(scene, setting);
  const auto options = options_of(setting);
  const auto ratio =
      static_cast<std::size_t>(std::find(ratios.begin(), ratios.end(), setting.scheme.ratio) - ratios.begin());
  for (const Window& window : reference.windows) {
    CoupledWorlds worlds(solved, options, profile.properties);
    worlds.start_from(window.before[ratio], window.now, reference.mean_on_proxy(window.start, setting.scheme.ratio));
    const auto wanted = std::span(reference.force).subspan(window.start, window_ticks(setting.scheme.ratio));
    const auto force = timed_window(worlds, reference, window, wanted.size(), sums);
    sums.error.add(force, wanted);
    std::vector<std::size_t> syncs;
    for (std::size_t k = setting.scheme.ratio; k < wanted.size(); k += setting.scheme.ratio) syncs.push_back(k);
    const auto steps = steps_at(force, wanted, syncs);
    sums.steps.insert(sums.steps.end(), steps.begin(), steps.end());
    if (window.hold) sums.vibration.push_back(band_deviation(difference(force, wanted), kHapticRate_Hz, 20, 500));
  }
}

}  // namespace tactus::experiment
