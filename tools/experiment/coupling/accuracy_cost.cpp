#include "tools/experiment/coupling/accuracy_cost.h"

#include <fmt/format.h>

#include <algorithm>

#include "rt/loop/governor.h"
#include "sim/model/choice_names.h"
#include "tools/experiment/instructions.h"
#include "tools/experiment/statistics.h"
#include "tools/experiment/timing.h"
#include "tools/session/open_link.h"
#include "tools/session/session.h"

namespace tactus::experiment {
namespace {

constexpr unsigned kCountedTicks = 16;  // two cycles at the default ratio, one at the largest

using physics::FrictionSweeps;
using physics::SweepPrecision;
using sim::CutOrder;

constexpr unsigned kDefaultRatio = 8;
constexpr double kReferenceWork = 5;  // work of the reference run, in units of one setting on its windows

CostPoint point_of(const std::string& scene, const Setting& setting, const SettingSums& sums) {
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
  point.global_us_per_tick = median(sums.global_us) / setting.ratio;
  return point;
}

// A single changed factor and its name.
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
  for (const unsigned n : {1u, 2u})
    add("relax sweeps", base.relax_sweeps, n, [n](Setting& s) {
      s.relax_sweeps = n;
      s.friction = physics::resolve(FrictionSweeps::kAuto, n);
    });
  for (const FrictionSweeps sweeps : {FrictionSweeps::kRelax, FrictionSweeps::kEvery})
    add("friction in sweeps", sim::name_of(base.friction), sim::name_of(sweeps),
        [sweeps](Setting& s) { s.friction = sweeps; });
  for (const double hertz : {250.0, 500.0, 1000.0})
    if (base.sub_steps >= least_sub_steps(hertz))
      add("contact frequency [Hz]", base.contact_Hz, hertz, [hertz](Setting& s) { s.contact_Hz = hertz; });
  for (const unsigned n : {base.members / 2, base.members * 2, base.members * 4})
    if (n > 0 && n / 2 < bodies) add("members", base.members, n, [n](Setting& s) { s.members = n; });
  for (const unsigned n : {2u, 4u, 8u, 16u}) add("ratio", base.ratio, n, [n](Setting& s) { s.ratio = n; });
  for (const auto border : physics::kBorderModes)
    add("border", sim::name_of(base.border), sim::name_of(border), [border](Setting& s) { s.border = border; });
  for (const CutOrder order : {CutOrder::kBestFirst, CutOrder::kBreadthFirst})
    add("extraction", sim::name_of(base.order), sim::name_of(order), [order](Setting& s) { s.order = order; });
  add("world precision", sim::name_of(base.precision), sim::name_of(SweepPrecision::kFull),
      [](Setting& s) { s.precision = SweepPrecision::kFull; });
  return changes;
}

Setting default_setting(const sim::Scene& scene, unsigned members) {
  Setting setting;
  setting.sub_steps = scene.solver.sub_steps;
  setting.relax_sweeps = scene.solver.relax_sweeps;
  setting.friction = physics::resolve(scene.solver.friction_sweeps, setting.relax_sweeps);
  setting.contact_Hz = scene.solver.contact_hertz;
  setting.members = members;
  setting.ratio = kDefaultRatio;
  return setting;
}

// Estimated work of a case per seed: its bodies times its settings.
double work_of(const sim::Scene& scene, const CouplingCase& one, bool quick) {
  return moving_bodies(scene) * (kReferenceWork + static_cast<double>(settings_for(scene, one.members, quick).size()));
}

Status measure_case(const CostRequest& request, const CouplingCase& one, const Pace& pace, double& done,
                    CostReport& report) {
  auto written = load_coupling_case(one, 0);
  if (!written.ok()) return written.status();
  const auto profile = session::find_description(written.value().device.profile, {});
  if (!profile.ok()) return profile.status();
  const auto settings = settings_for(written.value(), one.members, request.quick);
  std::vector<unsigned> ratios;
  for (const Setting& setting : settings)
    if (std::find(ratios.begin(), ratios.end(), setting.ratio) == ratios.end()) ratios.push_back(setting.ratio);
  std::vector<SettingSums> sums(settings.size());
  std::vector<std::vector<double>> errors(settings.size()), ticks_us(settings.size());  // by seed
  const double unit = moving_bodies(written.value());
  for (unsigned seed = 0; seed < request.seeds; ++seed) {
    auto scene = load_coupling_case(one, seed);
    if (!scene.ok()) return scene.status();
    const auto say = [&](const std::string& doing) {
      pace.say(fmt::format("scene {}, seed {} of {}: {}", one.name, seed + 1, request.seeds, doing), done);
    };
    say("reference");
    const ReferenceRun reference =
        record_fine(scene.value(), profile.value(), tick_at(HandTimes::kEnd), window_places(request.quick), ratios);
    done += kReferenceWork * unit;
    for (std::size_t i = 0; i < settings.size(); ++i) {
      say(fmt::format("setting {} of {}", i + 1, settings.size()));
      SettingSums of_seed;
      measure_setting(scene.value(), profile.value(), settings[i], reference, ratios, of_seed);
      errors[i].push_back(of_seed.error.relative());
      ticks_us[i].push_back(median(of_seed.ticks_us));
      sums[i].add(of_seed);
      done += unit;
    }
  }
  const std::size_t first = report.points.size();
  for (std::size_t i = 0; i < settings.size(); ++i) {
    report.points.push_back(point_of(one.name, settings[i], sums[i]));
    report.points.back().force_error_by_seed = errors[i];
    report.points.back().tick_us_by_seed = ticks_us[i];
  }
  const CostPoint& base = report.points[first];
  for (const Change& change : changes_of(settings[0], moving_bodies(written.value()))) {
    const auto at = std::find(settings.begin(), settings.end(), change.setting) - settings.begin();
    const CostPoint& to = report.points[first + static_cast<std::size_t>(at)];
    report.notches.push_back({.scene = one.name,
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
  const Pace pace(progress, static_cast<double>(runs));
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
        kCountedTicks;
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
  for (std::size_t k = 0; k < first + kCountedTicks; ++k) {
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
          for (const auto border : std::span(physics::kBorderModes).first(2)) {
            if (sub_steps < least_sub_steps(base.contact_Hz) || cap == 0 || cap / 2 >= bodies) continue;
            Setting setting = base;
            setting.sub_steps = sub_steps;
            setting.relax_sweeps = relax_sweeps;
            setting.friction = physics::resolve(FrictionSweeps::kAuto, relax_sweeps);
            setting.members = cap;
            setting.ratio = ratio;
            setting.border = border;
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

Result<CostReport> run_accuracy_cost(const CostRequest& request, const Progress& progress) {
  settle_on_core();
  CostReport report;
  report.seeds = request.seeds;
  report.period_us = 1e6 / kHapticRate_Hz;
  report.budget_us = loop::GovernorConfig{}.budget * report.period_us;
  double work = 0, done = 0;
  for (const CouplingCase& one : request.cases) {
    const auto scene = load_coupling_case(one, 0);
    if (!scene.ok()) return scene.status();
    work += request.seeds * work_of(scene.value(), one, request.quick);
  }
  const Pace pace(progress, work);
  for (const CouplingCase& one : request.cases)
    if (const Status status = measure_case(request, one, pace, done, report); !status.ok()) return status;
  mark_front(report.points);
  count_instructions(request, progress, report.points);
  return report;
}

}  // namespace tactus::experiment
