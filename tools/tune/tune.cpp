#include "tools/tune/tune.h"

#include <fmt/format.h>
#include <sched.h>

#include <algorithm>
#include <bit>

#include "sim/loader/scene_load.h"
#include "tools/experiment/statistics.h"
#include "tools/experiment/timing.h"
#include "tools/session/find_description.h"
#include "tools/session/realtime_run.h"

namespace tactus::tune {
namespace {

using experiment::kHapticRate_Hz;
using experiment::kWindowTicks;
using experiment::ReferenceRun;

constexpr double kFirstWindow_s = 0.3, kWindowEvery_s = 0.25;
// Estimated work for the progress display, in trials: the reference, a real-time run, and the number of trials.
constexpr double kReferenceWork = 6, kRealWork = 4, kTrials = 22;
constexpr int kMaxStepsBack = 3;
constexpr double kMaxCoreFactor = 4;

// Pins this thread to its current core for the object's lifetime; the destructor restores all cores, which a real-time
// run needs.
class OnOneCore {
 public:
  OnOneCore() {
    sched_getaffinity(0, sizeof before_, &before_);
    experiment::settle_on_core();
  }
  ~OnOneCore() { sched_setaffinity(0, sizeof before_, &before_); }
  OnOneCore(const OnOneCore&) = delete;
  OnOneCore& operator=(const OnOneCore&) = delete;

 private:
  cpu_set_t before_{};
};

session::RunOptions run_options(const TuneRequest& request, const CostSetting& setting, double duration_s) {
  session::RunOptions options = request.run;
  options.rate_Hz = kHapticRate_Hz;
  options.members = setting.members;
  options.ratio = setting.scheme.ratio;
  options.duration_s = duration_s;
  return options;
}

Result<RealRun> run_for_real(const TuneRequest& request, const CostSetting& setting, const std::atomic<bool>& stop) {
  auto session = session::Session::create(experiment::with(request.scene, setting),
                                          run_options(request, setting, request.verify_s));
  if (!session.ok()) return session.status();
  const auto ran = session::run_realtime(*session.value(), {}, stop);
  if (!ran.ok()) return ran.status();
  const session::RunSummary& summary = ran.value();
  const loop::RunStats& stats = summary.stats;
  const auto ticks_with = [&](StatusBit bit) {
    return static_cast<double>(stats.status_ticks[std::countr_zero(static_cast<std::uint32_t>(bit))]);
  };
  const auto us = [&](double percent) { return 1e-3 * static_cast<double>(summary.compute.percentile_ns(percent)); };
  const double ticks = std::max<double>(1, static_cast<double>(stats.ticks)),
               cycles = std::max<double>(1, static_cast<double>(stats.cycles));
  RealRun run;
  run.duration_s = summary.wall_s;
  run.tick_us_p50 = us(50);
  run.tick_us_p99 = us(99);
  run.tick_us_max = 1e-3 * static_cast<double>(summary.compute.max_ns());
  run.reduced_share = (ticks_with(kSubStepsReduced) + ticks_with(kSolverCut)) / ticks;
  run.restrained_share = static_cast<double>(stats.restrained_cycles) / cycles;
  run.late_share = static_cast<double>(stats.late_cycles) / cycles;
  run.lost = summary.overruns_own_work;
  run.degraded = summary.degraded();
  return run;
}

// Keeps the windows in which the hand presses most, in order of time.
void keep_strongest(ReferenceRun& reference, std::size_t count) {
  const auto force = [&](const experiment::Window& window) {
    double sum = 0;
    for (std::size_t k = window.start; k < window.start + kWindowTicks; ++k)
      if (reference.touches[k] != 0) sum += norm_squared(reference.force[k]);
    return sum;
  };
  auto& windows = reference.windows;
  std::erase_if(windows, [&](const auto& window) { return force(window) <= 0; });
  std::stable_sort(windows.begin(), windows.end(), [&](const auto& a, const auto& b) { return force(a) > force(b); });
  if (windows.size() > count) windows.resize(count);
}

// Measures settings against the reference, each once.
class SettingTrials {
 public:
  SettingTrials(const TuneRequest& request, const hal::DeviceProfile& profile) : request_(request), profile_(profile) {
    ratios_.assign(kRatios.begin(), kRatios.end());
    const unsigned written = request.run.ratio != 0 ? request.run.ratio : request.scene.ratio;
    if (std::find(ratios_.begin(), ratios_.end(), written) == ratios_.end()) ratios_.push_back(written);
    const auto& path = request.scene.hand.path;
    const double end_s = std::min(path.empty() ? 0.0 : path.back().time_s, request.quick ? 3.0 : 6.0);
    std::vector<experiment::WindowPlace> places;
    for (double at = kFirstWindow_s; at + kWindowTicks / kHapticRate_Hz < end_s; at += kWindowEvery_s)
      places.push_back({experiment::tick_at(at), true});
    reference_ = experiment::record_fine(request.scene, profile, experiment::tick_at(end_s), places, ratios_);
    keep_strongest(reference_, request.quick ? 2 : 4);
  }

  std::size_t windows() const { return reference_.windows.size(); }
  unsigned trials() const { return static_cast<unsigned>(known_.size()); }
  double core_factor{1};

  Trial measure(const CostSetting& setting) {
    const auto before =
        std::find_if(known_.begin(), known_.end(), [&](const Trial& t) { return t.setting == setting; });
    Trial trial = before != known_.end() ? *before : measure_again(setting);
    trial.tick_us_p50 *= core_factor;
    trial.tick_us_p99 *= core_factor;
    return trial;
  }

 private:
  Trial measure_again(const CostSetting& setting) {
    experiment::SettingSums sums;
    experiment::measure_setting(request_.scene, profile_, setting, reference_, ratios_, sums);
    known_.push_back({.setting = setting,
                      .force_error = sums.error.relative(),
                      .tick_us_p50 = experiment::median(sums.ticks_us),
                      .tick_us_p99 = experiment::quantile(sums.ticks_us, 0.99),
                      .global_us_per_tick = experiment::quantile(sums.global_us, 0.9) / setting.scheme.ratio});
    return known_.back();
  }

  const TuneRequest& request_;
  const hal::DeviceProfile& profile_;
  std::vector<unsigned> ratios_;
  ReferenceRun reference_;
  std::vector<Trial> known_;  // times of ticks run back to back
};

CostSetting written_setting(const TuneRequest& request, unsigned bodies) {
  const sim::Scene& scene = request.scene;
  CostSetting setting;
  setting.sub_steps = scene.solver.sub_steps;
  setting.relax_sweeps = scene.solver.relax_sweeps;
  setting.friction = scene.solver.friction_sweeps;
  setting.contact_Hz = scene.solver.contact_hertz;
  setting.members = std::min(request.run.members != 0 ? request.run.members : scene.members, bodies);
  setting.scheme.ratio = request.run.ratio != 0 ? request.run.ratio : scene.ratio;
  setting.scheme.border = request.run.border;
  setting.order = request.run.order;
  setting.precision = request.run.world_precision;
  return setting;
}

// If a setting fails in the real-time run, takes the most accurate step back in the part that failed: the time of the
// global world or of the tick.
Trial step_back(const Trial& from, const RealRun& real, const Limits& limits, SettingTrials& bench) {
  const bool world_is_late = real.late_share > kMaxMissed;
  std::vector<Trial> tried;
  for (const SettingStep& change : changes_down(from.setting, limits))
    if ((change.factor == "ratio") == world_is_late) tried.push_back(bench.measure(change.setting));
  if (tried.empty()) return from;
  return *std::min_element(tried.begin(), tried.end(),
                           [](const Trial& a, const Trial& b) { return a.force_error < b.force_error; });
}

}  // namespace

Result<TuneReport> run_tune(const TuneRequest& request, const experiment::Progress& progress,
                            const std::atomic<bool>& stop) {
  TuneReport report;
  report.file = request.file;
  report.scene = request.scene.name;
  report.scene_hash = sim::source_hash(request.scene.source);
  report.bodies = request.scene.moving_bodies();
  report.limits = request.limits;
  report.limits.bodies = report.bodies;
  if (report.bodies > haptics::kMaxMembers)
    return Status::error(
        fmt::format("{}: {} moving bodies; accepted: up to {}, for accuracy is measured against a run "
                    "of all of them",
                    request.scene.name, report.bodies, haptics::kMaxMembers));
  const auto profile = session::find_description(request.scene.device.profile, {});
  if (!profile.ok()) return profile.status();
  const CostSetting written = written_setting(request, report.bodies);
  report.of_scene = session::judge(sim::report_on(request.scene, profile.value().properties, request.run.period_s()));

  const experiment::WorkProgress pace(progress, kReferenceWork + kTrials + 2 * kRealWork);
  pace.say("the scene as it is written, in real time", 0);
  const auto real_written = run_for_real(request, written, stop);
  if (!real_written.ok()) return real_written.status();
  pace.say("reference: all bodies at 1 kHz", kRealWork);
  std::optional<OnOneCore> pinned(std::in_place);
  SettingTrials bench(request, profile.value());
  if (bench.windows() == 0)
    return Status::error(fmt::format("{}: the hand touches nothing in its first {} s; accepted: a script that does",
                                     request.scene.name, request.quick ? 3 : 6));
  report.windows = static_cast<unsigned>(bench.windows());
  const double in_a_row_us = bench.measure(written).tick_us_p99;
  bench.core_factor = std::clamp(real_written.value().tick_us_p99 / std::max(1e-3, in_a_row_us), 1.0, kMaxCoreFactor);
  report.core_factor = bench.core_factor;
  const Measure measure = [&](const CostSetting& setting) {
    pace.say(fmt::format("{} sub-steps, {} relax sweeps, {} members, ratio {}", setting.sub_steps, setting.relax_sweeps,
                         setting.members, setting.scheme.ratio),
             kRealWork + kReferenceWork + bench.trials());
    return bench.measure(setting);
  };
  report.written = measure(written);
  const Found found = search(written, report.limits, measure);
  report.chosen = found.best;
  report.fits = found.fits;
  pinned.reset();

  for (int back = 0; back <= kMaxStepsBack && !stop.load(std::memory_order_relaxed); ++back) {
    pace.say("the choice, in real time", kReferenceWork + kTrials + kRealWork);
    const auto real = run_for_real(request, report.chosen.setting, stop);
    if (!real.ok()) return real.status();
    report.real = real.value();
    if (report.real.holds() || back == kMaxStepsBack) break;
    report.chosen = step_back(report.chosen, report.real, report.limits, bench);
  }
  pinned.emplace();
  std::vector<SettingStep> further = changes_up(report.chosen.setting, report.limits);
  for (const SettingStep& change : changes_stiffer(report.chosen.setting)) further.push_back(change);
  for (const SettingStep& change : further) {
    const Trial trial = measure(change.setting);
    report.further.push_back({change, trial, trial.fits(report.limits)});
  }
  report.trials = bench.trials();
  return report;
}

}  // namespace tactus::tune
