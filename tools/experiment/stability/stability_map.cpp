#include "tools/experiment/stability/stability_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <thread>

#include "hal/profiles.h"
#include "rt/base/denormals.h"
#include "rt/thread/periodic_thread.h"

namespace tactus::experiment {
namespace {

constexpr const char* kFactors[] = {"rate", "delay", "jitter", "quantum"};

// Damping values, as shares of the accepted limit.
std::vector<double> damping_shares(bool quick) {
  if (quick) return {0.005, 0.04, 0.3, 1};
  return {0.005, 0.01, 0.02, 0.04, 0.08, 0.15, 0.3, 0.5, 0.75, 1};
}

MapRow measure(const MapRequest& request, const char* factor, const LoopTiming& timing, double damping_share) {
  const haptics::DeviceProperties device = device_in(request.description, timing);
  const double period_s = 1 / timing.rate_Hz;
  const double late_s = timing.jitter_ticks * period_s;
  const auto judge = [&](double damping) {
    haptics::CouplingGains gains;
    gains.damping_Ns_per_m = damping;
    return haptics::check_coupling(gains, device, period_s, late_s).translation;
  };
  MapRow row{.factor = factor,
             .timing = timing,
             .delay_s = device.delay_s,
             .damping_Ns_per_m = damping_share * judge(0).damping_limit,
             .measured_N_per_m = 0,
             .formula_N_per_m = 0,
             .line_N_per_m = 0,
             .allowed_N_per_m = 0};
  const haptics::AxisVerdict verdict = judge(row.damping_Ns_per_m);
  row.formula_N_per_m = verdict.stiffness_limit;
  row.allowed_N_per_m = verdict.stiffness_allowed;
  row.line_N_per_m =
      haptics::little_damping_limit(haptics::translation_of(device, period_s, late_s), row.damping_Ns_per_m);
  // Near the limit of the damping the stability boundary is far below the line.
  const double least_N_per_m = std::min(0.1 * row.line_N_per_m, std::max(0.25 * row.formula_N_per_m, 1.0));
  row.measured_N_per_m = measured_limit(request.description, timing, row.damping_Ns_per_m, least_N_per_m,
                                        4 * row.line_N_per_m, request.quick ? 1.04 : 1.02);
  return row;
}

}  // namespace

WakeLateness measure_wake(double rate_Hz, double seconds, int cpu) {
  struct Sleeper {
    bool operator()(const loop::TickTiming&) noexcept { return true; }
  } sleeper;
  loop::PeriodicThread thread(sleeper);
  loop::PeriodicSettings settings;
  settings.period = std::chrono::nanoseconds(std::llround(1e9 / rate_Hz));
  settings.setup.cpu = cpu;
  WakeLateness wake;
  if (!thread.start(settings).ok()) return wake;
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
  thread.stop();
  const Histogram& latency = thread.health().wake_latency;
  const auto at = [&](double percent) { return 1e-9 * static_cast<double>(latency.percentile_ns(percent)); };
  wake = {.typical_s = at(50),
          .late_s = at(99.9),
          .latest_s = 1e-9 * static_cast<double>(latency.max_ns()),
          .source = fmt::format("{} wake-ups of this PC", latency.count()),
          .degraded = thread.setup_report().degraded()};
  return wake;
}

std::vector<LoopTiming> loops_of(const std::string& factor, const LoopTiming& base, double quantum_m, bool quick) {
  std::vector<LoopTiming> loops;
  const auto add = [&](double LoopTiming::*what, std::initializer_list<double> values) {
    for (const double value : values) {
      loops.push_back(base);
      loops.back().*what = value;
    }
  };
  if (factor == "rate" && quick) add(&LoopTiming::rate_Hz, {1000, 4000});
  if (factor == "rate" && !quick) add(&LoopTiming::rate_Hz, {500, 1000, 2000, 4000});
  if (factor == "delay" && quick) add(&LoopTiming::delay_ticks, {0.1, 3});
  if (factor == "delay" && !quick) add(&LoopTiming::delay_ticks, {0.1, 0.5, 1, 2, 3});
  if (factor == "jitter" && quick) add(&LoopTiming::jitter_ticks, {0.5});
  if (factor == "jitter" && !quick) add(&LoopTiming::jitter_ticks, {0, 0.2, 0.5, 0.9});
  if (factor == "quantum" && quick) add(&LoopTiming::quantum_m, {quantum_m});
  if (factor == "quantum" && !quick) add(&LoopTiming::quantum_m, {0, quantum_m, 2 * quantum_m, 5 * quantum_m});
  return loops;
}

MapReport run_stability_map(const MapRequest& request, const Progress& progress) {
  set_denormals_flush();
  MapReport report;
  report.device = request.description.name;
  report.rate_Hz = request.rate_Hz;
  report.wake = request.wake;
  const hal::DeviceProfile profile = hal::make_profile(request.description);
  LoopTiming base;
  base.rate_Hz = request.rate_Hz;
  base.delay_ticks = request.description.transport_delay_ticks;
  const std::vector<double> shares = damping_shares(request.quick);
  struct Task {
    const char* factor;
    LoopTiming timing;
  };
  std::vector<Task> tasks;
  double work = 0, done = 0;  // device ticks: parts of the loop's ticks
  const auto work_of = [](const LoopTiming& t) { return t.rate_Hz * (parts_of_tick(t.rate_Hz) + 8); };
  for (const char* factor : kFactors)
    for (const LoopTiming& timing : loops_of(factor, base, profile.properties.position_quantum_m, request.quick)) {
      tasks.push_back({factor, timing});
      work += work_of(timing) * static_cast<double>(shares.size());
    }
  const WorkProgress pace(progress, work);
  report.least_of_formula = 1e9;
  for (const Task& task : tasks)
    for (const double share : shares) {
      pace.say(fmt::format("{}: {:g} Hz, delay {:g}, jitter {:g}, quantum {:g} um", task.factor, task.timing.rate_Hz,
                           task.timing.delay_ticks, task.timing.jitter_ticks, 1e6 * task.timing.quantum_m),
               done);
      const MapRow row = measure(request, task.factor, task.timing, share);
      if (row.formula_N_per_m > 0)
        report.least_of_formula = std::min(report.least_of_formula, row.measured_N_per_m / row.formula_N_per_m);
      if (row.measured_N_per_m < row.allowed_N_per_m) ++report.unsafe;
      report.rows.push_back(row);
      done += work_of(task.timing);
    }
  haptics::DeviceProperties device = profile.properties;
  device.delay_s = request.description.transport_delay_ticks / request.rate_Hz;
  report.suggested = haptics::suggest_gains(device, 1 / request.rate_Hz, request.wake.late_s);
  return report;
}

}  // namespace tactus::experiment
