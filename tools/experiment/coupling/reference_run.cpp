#include "tools/experiment/coupling/reference_run.h"

#include "rt/base/status.h"

namespace tactus::experiment {

Wrenchd ReferenceRun::mean_on_proxy(std::size_t tick, unsigned ticks) const {
  Wrenchd sum;
  for (std::size_t k = tick - ticks; k < tick; ++k) {
    sum.force -= on_device[k].force;
    sum.torque -= on_device[k].torque;
  }
  return {sum.force * (1.0 / ticks), sum.torque * (1.0 / ticks)};
}

ReferenceRun record_reference(CoupledWorlds& worlds, ScriptedArm& arm, std::size_t ticks,
                              std::span<const WindowPlace> places, std::span<const unsigned> ratios) {
  ReferenceRun run;
  for (const WindowPlace& place : places) {
    run.windows.push_back({place.start, place.hold, {}, {}});
    run.windows.back().before.resize(ratios.size());
  }
  worlds.start_at_rest();
  for (std::size_t k = 0; k < ticks; ++k) {
    if (k > 0) arm.advance(run.on_device.back());
    for (Window& window : run.windows) {
      if (k == window.start) window.now = worlds.moment(k, true);
      for (std::size_t i = 0; i < ratios.size(); ++i)
        if (k + ratios[i] == window.start) window.before[i] = worlds.moment(k, false);
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

}  // namespace tactus::experiment
