#include "tools/experiment/coupling/accuracy_cost.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "sim/choice_names.h"
#include "tools/experiment/coupling/force_measures.h"
#include "tools/experiment/coupling/reference_run.h"
#include "tools/experiment/statistics.h"
#include "tools/experiment/timing.h"
#include "tools/session/open_link.h"
#include "tools/session/session.h"

#if __has_include(<valgrind/callgrind.h>)
#include <valgrind/callgrind.h>
#define TACTUS_COUNTS_INSTRUCTIONS 1
#else
#define CALLGRIND_START_INSTRUMENTATION
#define CALLGRIND_STOP_INSTRUMENTATION
#define TACTUS_COUNTS_INSTRUCTIONS 0
#endif

namespace tactus::experiment {
namespace {

constexpr unsigned kCountedTicks = 16;  // two cycles at the default ratio, one at the largest

using haptics::CouplingScheme;
using physics::BorderMode;
using sim::CutOrder;

// Of the run that all settings are measured against.
constexpr unsigned kReferenceSubSteps = 16, kReferenceRelaxSweeps = 2;
constexpr unsigned kDefaultRatio = 8;

// Sub-steps of a tick that resolve a contact frequency: a quarter of them in a second.
unsigned least_sub_steps(double contact_Hz) {
  return static_cast<unsigned>(std::ceil(4 * contact_Hz / kHapticRate_Hz - 1e-9));
}

sim::Scene with(sim::Scene scene, const Setting& setting) {
  scene.solver.sub_steps = setting.sub_steps;
  scene.solver.relax_sweeps = setting.relax_sweeps;
  scene.solver.contact_hertz = setting.contact_Hz;
  scene.solver.global_sub_steps_per_tick =
      std::max<double>(scene.solver.global_sub_steps_per_tick, least_sub_steps(setting.contact_Hz));
  return scene;
}

session::RunOptions options_of(const Setting& setting, CouplingScheme coupling) {
  session::RunOptions options;
  options.coupling = coupling;
  options.border = setting.border;
  options.order = setting.order;
  options.ratio = setting.ratio;
  options.members = setting.members;
  options.rate_Hz = kHapticRate_Hz;
  return options;
}

struct Sums {
  ForceError error;
  EnergyBook energy;
  std::vector<double> vibration, steps, ticks_us, global_us;
};

// A window, timed part by part.
std::vector<Vec3d> timed_window(CoupledWorlds& worlds, const ReferenceRun& reference, const Window& window,
                                Sums& sums) {
  std::vector<Vec3d> force;
  const double stiffness_N_per_m = worlds.sub_world().config().stiffness_N_per_m;
  for (std::size_t k = window.start; k < window.start + kWindowTicks; ++k) {
    if (!window.hold && k > window.start && worlds.at_synchronisation())
      sums.energy.add(worlds.motion(), reference.motion[k], 0.5 * norm_squared(reference.force[k]) / stiffness_N_per_m);
    const double begin_us = thread_time_us();
    const bool synchronised = worlds.synchronise();
    double haptic_us = thread_time_us() - begin_us;
    if (synchronised) {
      const double step_us = thread_time_us();
      worlds.serve();
      sums.global_us.push_back(thread_time_us() - step_us);
    }
    const double again_us = thread_time_us();
    force.push_back(worlds.step(reference.ideal[k]).on_device.force);
    sums.ticks_us.push_back(haptic_us + thread_time_us() - again_us);
  }
  sums.energy.close_window();
  return force;
}

void measure(const sim::Scene& scene, const hal::DeviceProfile& profile, const Setting& setting,
             const ReferenceRun& reference, std::span<const unsigned> ratios, Sums& sums) {
  const sim::Scene solved = with(scene, setting);
  const auto options = options_of(setting, CouplingScheme::kSubWorld);
  const auto ratio = static_cast<std::size_t>(std::find(ratios.begin(), ratios.end(), setting.ratio) - ratios.begin());
  for (const Window& window : reference.windows) {
    CoupledWorlds worlds(solved, options, profile.properties);
    worlds.start_from(window.before[ratio], window.now, reference.mean_on_proxy(window.start, setting.ratio));
    const auto wanted = std::span(reference.force).subspan(window.start, kWindowTicks);
    const auto force = timed_window(worlds, reference, window, sums);
    sums.error.add(force, wanted);
    std::vector<std::size_t> syncs;
    for (std::size_t k = setting.ratio; k < kWindowTicks; k += setting.ratio) syncs.push_back(k);
    const auto steps = steps_at(force, wanted, syncs);
    sums.steps.insert(sums.steps.end(), steps.begin(), steps.end());
    if (window.hold) sums.vibration.push_back(band_deviation(difference(force, wanted), kHapticRate_Hz, 20, 500));
  }
}

CostPoint point_of(const std::string& scene, const Setting& setting, const Sums& sums) {
  CostPoint point;
  point.scene = scene;
  point.setting = setting;
  point.force_error = sums.error.relative();
  point.hold_vibration_N = median(sums.vibration);
  point.sync_step_N = quantile(sums.steps, 0.95);
  point.loss = sums.energy.kinetic().loss, point.gain = sums.energy.kinetic().gain;
  point.tick_us_p50 = median(sums.ticks_us), point.tick_us_p99 = quantile(sums.ticks_us, 0.99);
  point.tick_us_max = quantile(sums.ticks_us, 1);
  point.global_us_per_tick = median(sums.global_us) / setting.ratio;
  return point;
}

// What each factor is changed to, alone, and how it is called.
struct Change {
  std::string factor, from, to;
  Setting setting;
};

std::vector<Change> changes_of(const Setting& base, unsigned bodies) {
  std::vector<Change> changes;
  const auto add = [&](const char* factor, auto from, auto to, auto&& set) {
    Setting changed = base;
    set(changed);
    if (!(changed == base)) changes.push_back({factor, fmt::format("{}", from), fmt::format("{}", to), changed});
  };
  for (const unsigned n : {2u, 4u, 8u, 16u})
    if (n >= least_sub_steps(base.contact_Hz))
      add("sub-steps", base.sub_steps, n, [n](Setting& s) { s.sub_steps = n; });
  for (const unsigned n : {1u, 2u}) add("relax sweeps", base.relax_sweeps, n, [n](Setting& s) { s.relax_sweeps = n; });
  for (const double hertz : {250.0, 500.0, 1000.0})
    if (base.sub_steps >= least_sub_steps(hertz))
      add("contact frequency [Hz]", base.contact_Hz, hertz, [hertz](Setting& s) { s.contact_Hz = hertz; });
  for (const unsigned n : {base.members / 2, base.members * 2, base.members * 4})
    if (n > 0 && n / 2 < bodies) add("members", base.members, n, [n](Setting& s) { s.members = n; });
  for (const unsigned n : {2u, 4u, 8u, 16u}) add("ratio", base.ratio, n, [n](Setting& s) { s.ratio = n; });
  for (const BorderMode border : {BorderMode::kGhost, BorderMode::kCapped, BorderMode::kReplay, BorderMode::kFrozen})
    add("border", sim::name_of(base.border), sim::name_of(border), [border](Setting& s) { s.border = border; });
  for (const CutOrder order : {CutOrder::kBestFirst, CutOrder::kBreadthFirst})
    add("extraction", sim::name_of(base.order), sim::name_of(order), [order](Setting& s) { s.order = order; });
  return changes;
}

Setting default_setting(const sim::Scene& scene, unsigned members) {
  return {scene.solver.sub_steps, scene.solver.relax_sweeps, scene.solver.contact_hertz, members,
          kDefaultRatio,          BorderMode::kGhost,        CutOrder::kBestFirst};
}

unsigned moving_bodies(const sim::Scene& scene) {
  return static_cast<unsigned>(std::count_if(scene.bodies.begin(), scene.bodies.end(), [](const auto& body) {
    return body.kind == physics::BodyKind::kDynamic;
  }));
}

ReferenceRun record(const sim::Scene& scene, const hal::DeviceProfile& profile, bool quick,
                    std::span<const unsigned> ratios) {
  sim::Scene fine = scene;
  fine.solver.sub_steps = kReferenceSubSteps;
  fine.solver.relax_sweeps = kReferenceRelaxSweeps;
  const auto options = options_of({}, CouplingScheme::kDirect);
  CoupledWorlds direct(fine, options, profile.properties);
  const auto config = session::loop_config(fine, options, profile.properties);
  ScriptedArm arm(profile, session::make_hand(fine), config.placement, config.period_s);
  return record_reference(direct, arm, tick_at(HandTimes::kEnd), window_places(quick), ratios);
}

Status measure_case(const CostRequest& request, const CouplingCase& one, const Progress& progress, CostReport& report) {
  auto written = load_coupling_case(one, 0);
  if (!written.ok()) return written.status();
  const auto profile = session::find_description(written.value().device.profile, {});
  if (!profile.ok()) return profile.status();
  const auto settings = settings_for(written.value(), one.members, request.quick);
  std::vector<unsigned> ratios;
  for (const Setting& setting : settings)
    if (std::find(ratios.begin(), ratios.end(), setting.ratio) == ratios.end()) ratios.push_back(setting.ratio);
  std::vector<Sums> sums(settings.size());
  for (unsigned seed = 0; seed < request.seeds; ++seed) {
    auto scene = load_coupling_case(one, seed);
    if (!scene.ok()) return scene.status();
    const auto say = [&](const std::string& doing) {
      if (progress) progress(fmt::format("scene {}, seed {} of {}: {}", one.name, seed + 1, request.seeds, doing));
    };
    say("reference");
    const ReferenceRun reference = record(scene.value(), profile.value(), request.quick, ratios);
    for (std::size_t i = 0; i < settings.size(); ++i) {
      say(fmt::format("setting {} of {}", i + 1, settings.size()));
      measure(scene.value(), profile.value(), settings[i], reference, ratios, sums[i]);
    }
  }
  const std::size_t first = report.points.size();
  for (std::size_t i = 0; i < settings.size(); ++i) report.points.push_back(point_of(one.name, settings[i], sums[i]));
  const CostPoint& base = report.points[first];
  for (const Change& change : changes_of(settings[0], moving_bodies(written.value()))) {
    const auto at = std::find(settings.begin(), settings.end(), change.setting) - settings.begin();
    const CostPoint& to = report.points[first + static_cast<std::size_t>(at)];
    report.notches.push_back({one.name, change.factor, change.from, change.to, base.force_error, to.force_error,
                              base.tick_us_p50, to.tick_us_p50});
  }
  report.points[first].is_default = true;
  return Status::good();
}

// Instructions of a tick by callgrind; 0 where it could not be counted.
double counted(const std::string& program, std::size_t scene, std::size_t setting, bool quick) {
  const std::string out = fmt::format("/tmp/tactus-callgrind.{}", getpid());
  const std::string command = fmt::format(
      "valgrind --tool=callgrind --callgrind-out-file={} --instr-atstart=no '{}' experiment accuracy-cost --count {} "
      "{}{}"
      " >/dev/null 2>&1",
      out, program, scene, setting, quick ? " --quick" : "");
  if (std::system(command.c_str()) != 0) return 0;
  std::ifstream file(out);
  double instructions = 0;
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("summary:") || line.starts_with("totals:"))
      instructions = std::strtod(line.c_str() + line.find(':') + 1, nullptr);
  std::remove(out.c_str());
  return instructions / kCountedTicks;
}

void count_instructions(const CostRequest& request, const Progress& progress, std::vector<CostPoint>& points) {
  if (TACTUS_COUNTS_INSTRUCTIONS == 0 || request.program.empty() ||
      std::system("command -v valgrind >/dev/null 2>&1") != 0)
    return;
  const auto cases = coupling_cases();
  std::size_t setting = 0;
  for (std::size_t i = 0; i < points.size(); ++i, ++setting) {
    if (points[i].is_default) setting = 0;  // the first of its scene
    if (!points[i].on_front && !points[i].is_default) continue;
    if (progress) progress(fmt::format("scene {}: instructions of setting {}", points[i].scene, setting + 1));
    const auto scene =
        std::find_if(cases.begin(), cases.end(), [&](const auto& c) { return c.name == points[i].scene; });
    points[i].instructions =
        counted(request.program, static_cast<std::size_t>(scene - cases.begin()), setting, request.quick);
  }
}

}  // namespace

Status run_counted(const CouplingCase& one, std::size_t setting, bool quick) {
  auto scene = load_coupling_case(one, 0);
  if (!scene.ok()) return scene.status();
  const auto profile = session::find_description(scene.value().device.profile, {});
  if (!profile.ok()) return profile.status();
  const auto settings = settings_for(scene.value(), one.members, quick);
  if (setting >= settings.size()) return Status::error("tactus experiment accuracy-cost: --count: no such setting");
  const sim::Scene solved = with(scene.value(), settings[setting]);
  const auto options = options_of(settings[setting], CouplingScheme::kSubWorld);
  CoupledWorlds worlds(solved, options, profile.value().properties);
  const auto config = session::loop_config(solved, options, profile.value().properties);
  ScriptedArm arm(profile.value(), session::make_hand(solved), config.placement, config.period_s);
  worlds.start_at_rest();
  const std::size_t first = tick_at(HandTimes::kPressed) / 16 * 16;  // where a cycle begins, at every ratio
  for (std::size_t k = 0; k < first + kCountedTicks; ++k) {
    if (k > 0) arm.advance(worlds.last().on_device);
    const bool count = k >= first;
    if (count) { CALLGRIND_START_INSTRUMENTATION; }
    const bool synchronised = worlds.synchronise();
    if (count) { CALLGRIND_STOP_INSTRUMENTATION; }
    if (synchronised) worlds.serve();
    if (count) { CALLGRIND_START_INSTRUMENTATION; }
    (void)worlds.step(arm.ideal());
    if (count) { CALLGRIND_STOP_INSTRUMENTATION; }
  }
  return Status::good();
}

std::vector<Setting> settings_for(const sim::Scene& scene, unsigned members, bool quick) {
  const Setting base = default_setting(scene, members);
  std::vector<Setting> settings{base};
  const auto add = [&](const Setting& setting) {
    if (std::find(settings.begin(), settings.end(), setting) == settings.end()) settings.push_back(setting);
  };
  const unsigned bodies = moving_bodies(scene);
  for (const Change& change : changes_of(base, bodies)) add(change.setting);
  if (quick) return settings;
  for (const unsigned sub_steps : {2u, 4u, 8u, 16u})
    for (const unsigned relax_sweeps : {1u, 2u})
      for (const unsigned cap : {members / 2, members, 2 * members})
        for (const unsigned ratio : {4u, 8u, 16u})
          for (const BorderMode border : {BorderMode::kGhost, BorderMode::kCapped})
            if (sub_steps >= least_sub_steps(base.contact_Hz) && cap > 0 && cap / 2 < bodies)
              add({sub_steps, relax_sweeps, base.contact_Hz, cap, ratio, border, base.order});
  return settings;
}

void mark_front(std::vector<CostPoint>& points) {
  for (CostPoint& point : points)
    point.on_front = std::none_of(points.begin(), points.end(), [&](const CostPoint& other) {
      return other.scene == point.scene && other.force_error <= point.force_error &&
             other.tick_us_p50 <= point.tick_us_p50 &&
             (other.force_error < point.force_error || other.tick_us_p50 < point.tick_us_p50);
    });
}

Result<CostReport> run_accuracy_cost(const CostRequest& request, const Progress& progress) {
  settle_on_core();
  CostReport report;
  report.seeds = request.seeds;
  for (const CouplingCase& one : request.cases)
    if (const Status status = measure_case(request, one, progress, report); !status.ok()) return status;
  mark_front(report.points);
  count_instructions(request, progress, report.points);
  return report;
}

}  // namespace tactus::experiment
