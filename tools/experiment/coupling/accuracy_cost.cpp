#include "tools/experiment/coupling/accuracy_cost.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <span>

#include "rt/base/denormals.h"
#include "rt/loop/governor.h"
#include "sim/model/choice_names.h"
#include "sim/model/step_settings.h"
#include "tools/experiment/instructions.h"
#include "tools/experiment/statistics.h"
#include "tools/experiment/timing.h"
#include "tools/session/find_description.h"
#include "tools/session/session.h"

namespace tactus::experiment {
namespace {

constexpr unsigned kCountedCycleTicks = 16;  // two cycles at the default ratio, one at the largest

using physics::FrictionSweeps;
using physics::SweepPrecision;
using sim::CutOrder;

constexpr unsigned kDefaultRatio = 8;
constexpr double kReferenceWork = 5;  // work of the reference run, in units of one setting on its windows

CostPoint point_of(const std::string& scene, const CostSetting& setting, const SettingSums& sums) {
  CostPoint point;
  point.scene = scene;
  point.setting = setting;
  point.force_error = sums.error.relative();
  point.hold_vibration_N = median(sums.vibration);
  point.sync_step_N = quantile(sums.steps, 0.95);
  point.loss = sums.energy.kinetic().loss;
  point.gain = sums.energy.kinetic().gain;
  point.tick_us_p50 = median(sums.ticks_us);
  point.tick_us_p99 = quantile(sums.ticks_us, 0.99);
  point.tick_us_max = quantile(sums.ticks_us, 1);
  point.global_us_per_tick = median(sums.global_us) / setting.scheme.ratio;
  return point;
}

// A single changed factor and its name.
struct Change {
  std::string factor, from, to;
  CostSetting setting;
};

std::vector<Change> changes_of(const CostSetting& base, unsigned bodies) {
  std::vector<Change> changes;
  const auto add = [&](const char* factor, auto from, auto to, auto&& set) {
    CostSetting changed = base;
    set(changed);
    if (!(changed == base))
      changes.push_back(
          {.factor = factor, .from = fmt::format("{}", from), .to = fmt::format("{}", to), .setting = changed});
  };
  for (const unsigned n : {2u, 4u, 8u, 16u})
    if (n >= sim::least_sub_steps(base.contact_Hz, 1 / kHapticRate_Hz))
      add("sub-steps", base.sub_steps, n, [n](CostSetting& s) { s.sub_steps = n; });
  for (const unsigned n : {1u, 2u})
    add("relax sweeps", base.relax_sweeps, n, [n](CostSetting& s) {
      s.relax_sweeps = n;
      s.friction = physics::resolve(FrictionSweeps::kAuto, n);
    });
  for (const FrictionSweeps sweeps : {FrictionSweeps::kRelax, FrictionSweeps::kEvery})
    add("friction in sweeps", sim::name_of(base.friction), sim::name_of(sweeps),
        [sweeps](CostSetting& s) { s.friction = sweeps; });
  for (const double hertz : {250.0, 500.0, 1000.0})
    if (base.sub_steps >= sim::least_sub_steps(hertz, 1 / kHapticRate_Hz))
      add("contact frequency [Hz]", base.contact_Hz, hertz, [hertz](CostSetting& s) { s.contact_Hz = hertz; });
  for (const unsigned n : {base.members / 2, base.members * 2, base.members * 4})
    if (n > 0 && n / 2 < bodies) add("members", base.members, n, [n](CostSetting& s) { s.members = n; });
  for (const unsigned n : {2u, 4u, 8u, 16u})
    add("ratio", base.scheme.ratio, n, [n](CostSetting& s) { s.scheme.ratio = n; });
  for (const Scheme& other : every_border())
    add("border", name_of_border(base.scheme), name_of_border(other),
        [&](CostSetting& s) { s.scheme.border = other.border; });
  for (const CutOrder order : {CutOrder::kBestFirst, CutOrder::kBreadthFirst})
    add("extraction", sim::name_of(base.order), sim::name_of(order), [order](CostSetting& s) { s.order = order; });
  add("world precision", sim::name_of(base.precision), sim::name_of(SweepPrecision::kFull),
      [](CostSetting& s) { s.precision = SweepPrecision::kFull; });
  return changes;
}

CostSetting default_setting(const sim::Scene& scene, unsigned members) {
  CostSetting setting;
  setting.sub_steps = scene.solver.sub_steps;
  setting.relax_sweeps = scene.solver.relax_sweeps;
  setting.friction = physics::resolve(scene.solver.friction_sweeps, setting.relax_sweeps);
  setting.contact_Hz = scene.solver.contact_hertz;
  setting.members = members;
  setting.scheme.ratio = kDefaultRatio;
  return setting;
}

// Estimated work of a case per seed: its bodies times its settings.
double work_of(const sim::Scene& scene, const CouplingCase& one, bool quick) {
  return scene.moving_bodies() * (kReferenceWork + static_cast<double>(settings_for(scene, one.members, quick).size()));
}

std::vector<unsigned> ratios_of(const std::vector<CostSetting>& settings) {
  std::vector<unsigned> ratios;
  for (const CostSetting& setting : settings)
    if (std::find(ratios.begin(), ratios.end(), setting.scheme.ratio) == ratios.end())
      ratios.push_back(setting.scheme.ratio);
  return ratios;
}

// Called before the reference (setting 0) and before each setting, from 1.
using BeforeSetting = std::function<void(std::size_t setting, std::size_t settings)>;

Result<HandSums> measure_settings(const CouplingCase& one, unsigned seed, bool quick, const BeforeSetting& before) {
  // The settings are those of the scene with its first hand.
  const auto written = load_coupling_case(one, 0), scene = load_coupling_case(one, seed);
  if (!written.ok()) return written.status();
  if (!scene.ok()) return scene.status();
  const auto profile = session::find_description(written.value().device.profile, {});
  if (!profile.ok()) return profile.status();
  const auto settings = settings_for(written.value(), one.members, quick);
  const auto ratios = ratios_of(settings);
  before(0, settings.size());
  const ReferenceRun reference =
      record_fine(scene.value(), profile.value(), tick_at(HandTimes::kEnd), window_places(quick), ratios);
  HandSums sums(settings.size());
  for (std::size_t i = 0; i < settings.size(); ++i) {
    before(i + 1, settings.size());
    measure_setting(scene.value(), profile.value(), settings[i], reference, ratios, sums[i]);
  }
  return sums;
}

// Of one scene, hand by hand.
struct CaseSums {
  std::vector<SettingSums> all;
  std::vector<std::vector<double>> errors, ticks_us;  // by hand

  void add(const HandSums& hand) {
    all.resize(hand.size());
    errors.resize(hand.size());
    ticks_us.resize(hand.size());
    for (std::size_t i = 0; i < hand.size(); ++i) {
      errors[i].push_back(hand[i].error.relative());
      if (!hand[i].ticks_us.empty()) ticks_us[i].push_back(median(hand[i].ticks_us));
      all[i].add(hand[i]);
    }
  }
};

Status measure_case(const CostRequest& request, const CouplingCase& one, std::span<const HandSums> measured,
                    const WorkProgress& pace, double& done, CostReport& report) {
  auto written = load_coupling_case(one, 0);
  if (!written.ok()) return written.status();
  const auto settings = settings_for(written.value(), one.members, request.quick);
  const double unit = written.value().moving_bodies();
  CaseSums sums;
  for (unsigned seed = 0; seed < request.seeds; ++seed) {
    if (seed > 0 && !measured.empty()) {
      sums.add(measured[seed - 1]);
      continue;
    }
    const auto hand = measure_settings(one, seed, request.quick, [&](std::size_t setting, std::size_t settings_in_all) {
      const std::string doing = setting == 0 ? "reference" : fmt::format("setting {} of {}", setting, settings_in_all);
      pace.say(fmt::format("scene {}, seed {} of {}: {}", one.name, seed + 1, request.seeds, doing), done);
      done += setting == 0 ? kReferenceWork * unit : unit;
    });
    if (!hand.ok()) return hand.status();
    sums.add(hand.value());
  }
  const std::size_t first = report.points.size();
  for (std::size_t i = 0; i < settings.size(); ++i) {
    report.points.push_back(point_of(one.name, settings[i], sums.all[i]));
    report.points.back().force_error_by_seed = sums.errors[i];
    report.points.back().tick_us_by_seed = sums.ticks_us[i];
  }
  const CostPoint& base = report.points[first];
  for (const Change& change : changes_of(settings[0], written.value().moving_bodies())) {
    const auto at = std::find(settings.begin(), settings.end(), change.setting) - settings.begin();
    const CostPoint& to = report.points[first + static_cast<std::size_t>(at)];
    report.changes.push_back({.scene = one.name,
                              .factor = change.factor,
                              .from = change.from,
                              .to = change.to,
                              .error_before = base.force_error,
                              .error_after = to.force_error,
                              .tick_us_before = base.tick_us_p50,
                              .tick_us_after = to.tick_us_p50,
                              .global_us_before = base.global_us_per_tick,
                              .global_us_after = to.global_us_per_tick});
  }
  report.points[first].is_default = true;
  return Status::good();
}

void count_instructions(const CostRequest& request, const Progress& progress, std::vector<CostPoint>& points) {
  if (request.program.empty() || !can_count_instructions()) return;
  const auto cases = coupling_cases();
  const auto wanted = [](const CostPoint& point) { return point.on_front || point.is_default; };
  const auto runs = std::count_if(points.begin(), points.end(), wanted);
  const WorkProgress pace(progress, static_cast<double>(runs));
  double done = 0;
  std::size_t setting = 0;
  for (std::size_t i = 0; i < points.size(); ++i, ++setting) {
    if (points[i].is_default) setting = 0;  // the first of its scene
    if (!wanted(points[i])) continue;
    pace.say(fmt::format("instructions: scene {}, {} of {}", points[i].scene, done + 1, runs), done);
    done += 1;
    const auto scene =
        std::find_if(cases.begin(), cases.end(), [&](const auto& c) { return c.name == points[i].scene; });
    points[i].instructions =
        counted_instructions(request.program,
                             fmt::format("experiment accuracy-cost --count {} {}{}", scene - cases.begin(), setting,
                                         request.quick ? " --quick" : "")) /
        kCountedCycleTicks;
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
  const auto options = options_of(settings[setting]);
  CoupledWorlds worlds(solved, options, profile.value().properties);
  const auto config = session::loop_config(solved, options, profile.value().properties);
  ScriptedArm arm(profile.value(), session::make_hand(solved), config.placement, config.period_s);
  worlds.start_at_rest();
  const std::size_t first = tick_at(HandTimes::kPressed) / 16 * 16;  // the beginning of a cycle, at every ratio
  for (std::size_t k = 0; k < first + kCountedCycleTicks; ++k) {
    if (k > 0) arm.advance(worlds.last().on_device);
    const bool count = k >= first;
    if (count) start_counting();
    const bool synchronised = worlds.synchronise();
    if (count) stop_counting();
    if (synchronised) worlds.serve();
    if (count) start_counting();
    (void)worlds.step(arm.ideal());
    if (count) stop_counting();
  }
  return Status::good();
}

std::vector<CostSetting> settings_for(const sim::Scene& scene, unsigned members, bool quick) {
  const CostSetting base = default_setting(scene, members);
  std::vector<CostSetting> settings{base};
  const auto add = [&](const CostSetting& setting) {
    if (std::find(settings.begin(), settings.end(), setting) == settings.end()) settings.push_back(setting);
  };
  const unsigned bodies = scene.moving_bodies();
  for (const Change& change : changes_of(base, bodies)) add(change.setting);
  if (quick) return settings;
  const std::vector<Scheme> borders = every_border();
  for (const unsigned sub_steps : {2u, 4u, 8u, 16u})
    for (const unsigned relax_sweeps : {1u, 2u})
      for (const unsigned cap : {members / 2, members, 2 * members})
        for (const unsigned ratio : {4u, 8u, 16u})
          for (const Scheme& of_border : std::span(borders).first(2)) {
            if (sub_steps < sim::least_sub_steps(base.contact_Hz, 1 / kHapticRate_Hz) || cap == 0 || cap / 2 >= bodies)
              continue;
            CostSetting setting = base;
            setting.sub_steps = sub_steps;
            setting.relax_sweeps = relax_sweeps;
            setting.friction = physics::resolve(FrictionSweeps::kAuto, relax_sweeps);
            setting.members = cap;
            setting.scheme.ratio = ratio;
            setting.scheme.border = of_border.border;
            add(setting);
          }
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

Result<HandSums> measure_hand(const CouplingCase& one, unsigned seed, bool quick, const Progress& progress) {
  set_denormals_flush();
  return measure_settings(one, seed, quick, [&](std::size_t setting, std::size_t settings) {
    if (progress) progress(fmt::format("scene {}, setting {} of {}", one.name, setting, settings));
  });
}

Result<CostReport> run_accuracy_cost(const CostRequest& request, const std::vector<HandSums>& measured,
                                     const Progress& progress) {
  settle_on_core();
  CostReport report;
  report.seeds = request.seeds;
  report.timed_seeds = measured.empty() ? request.seeds : 1;
  report.period_us = 1e6 / kHapticRate_Hz;
  report.budget_us = loop::GovernorConfig{}.budget * report.period_us;
  double work = 0, done = 0;
  for (const CouplingCase& one : request.cases) {
    const auto scene = load_coupling_case(one, 0);
    if (!scene.ok()) return scene.status();
    work += report.timed_seeds * work_of(scene.value(), one, request.quick);
  }
  const WorkProgress pace(progress, work);
  std::span<const HandSums> left(measured);
  for (const CouplingCase& one : request.cases) {
    const auto of_case = left.first(measured.empty() ? 0 : request.seeds - 1);
    left = left.subspan(of_case.size());
    if (const Status status = measure_case(request, one, of_case, pace, done, report); !status.ok()) return status;
  }
  mark_front(report.points);
  count_instructions(request, progress, report.points);
  return report;
}

}  // namespace tactus::experiment
