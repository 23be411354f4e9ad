#include "tools/experiment/scaling.h"

#include <fmt/format.h>
#include <sched.h>

#include <cmath>

#include "rt/thread/realtime_setup.h"
#include "sim/model/choice_names.h"
#include "tools/experiment/instructions.h"
#include "tools/experiment/statistics.h"
#include "tools/experiment/timing.h"

namespace tactus::experiment {
namespace {

constexpr unsigned kCountedSteps = 3;
constexpr std::uint32_t kCountedMost = 1000;  // cubes: larger worlds take minutes under valgrind and are timed only

constexpr std::uint32_t kMixedCubes = 10000;  // of the worlds with cubes of many sizes

BoxScene scene_of(const ScalingCase& one) { return make_pile(one.sweep, one.pile); }

// Cores for the additional threads; this thread is pinned to one of `cores`.
std::vector<int> helpers_of(const ScalingCase& one, const std::vector<int>& cores) {
  std::vector<int> helpers;
  const int own = sched_getcpu();
  for (const int core : cores)
    if (core != own && helpers.size() + 1 < one.threads) helpers.push_back(core);
  return helpers;
}

std::unique_ptr<Engine> settled(const ScalingCase& one, EngineOptions options, double settle_s) {
  options.sub_steps = one.sub_steps;
  auto engine = make_tactus(scene_of(one), options);
  const auto steps = static_cast<std::uint32_t>(std::lround(settle_s / one.pile.step_s));
  for (std::uint32_t i = 0; i < steps; ++i) engine->step();
  return engine;
}

ScalingRow timed(const ScalingCase& one, const EngineOptions& options, const std::vector<int>& cores) {
  EngineOptions timed_options = options;
  timed_options.time_broad_phase = true;
  timed_options.helpers = helpers_of(one, cores);
  const auto time_us = one.threads > 0 ? wall_time_us : thread_time_us;
  const auto engine = settled(one, timed_options, one.settle_s);
  std::vector<double> us, broad_phase_us;
  us.reserve(one.timed_steps);
  broad_phase_us.reserve(one.timed_steps);
  for (std::uint32_t i = 0; i < one.timed_steps; ++i) {
    const double start = time_us();
    engine->step();
    us.push_back(time_us() - start);
    broad_phase_us.push_back(engine->broad_phase_us());
  }
  const Measurement m = engine->measure();
  ScalingRow row;
  row.sweep = one.sweep;
  row.bodies = one.pile.cubes;
  row.sub_steps = one.sub_steps;
  row.threads = static_cast<std::uint32_t>(timed_options.helpers.size()) + 1;
  row.size_ratio = one.pile.largest_edge_m / one.pile.smallest_edge_m;
  row.contact_points = m.contacts;
  row.touching_pairs = m.touching_pairs;
  row.broad_phase_us = median(broad_phase_us);
  row.median_us = median(us);
  row.p99_us = quantile(us, 0.99);
  row.ns_per_point = m.contacts > 0 ? 1e3 * row.median_us / m.contacts : 0;
  row.failure = engine->failure();
  return row;
}

// Instructions of a step; 0: not counted.
double counted(std::size_t index, const EngineOptions& options, const std::string& program, bool quick) {
  const std::string precision =
      options.precision ? fmt::format(" --precision {}", sim::name_of(*options.precision)) : "";
  return counted_instructions(
             program, fmt::format("experiment scaling --count {}{}{}", index, precision, quick ? " --quick" : "")) /
         kCountedSteps;
}

}  // namespace

std::vector<ScalingCase> scaling_cases(bool quick, std::size_t cores) {
  std::vector<ScalingCase> cases;
  // From a hundred contact points to a hundred thousand.
  for (const std::uint32_t cubes : {16u, 64u, 250u, 1000u, 4000u, 10000u, 25000u}) {
    if (quick && cubes > 1000) continue;
    cases.push_back({"bodies", {.cubes = cubes, .step_s = 1e-2}});
  }
  for (const unsigned sub_steps : {1u, 2u, 4u, 8u, 16u})
    cases.push_back({"sub-steps", {.cubes = 250, .step_s = 1e-2}, sub_steps});
  for (const double ratio : {1.0, 3.0, 10.0, 20.0})
    cases.push_back({.sweep = "sizes",
                     .pile = {.cubes = quick ? 1000 : kMixedCubes,
                              .step_s = 1e-2,
                              .smallest_edge_m = 0.1 / std::sqrt(ratio),
                              .largest_edge_m = 0.1 * std::sqrt(ratio)},
                     .settle_s = 8});  // small cubes take longer to settle between large ones
  for (const std::uint32_t cubes : {64u, 1000u, 5000u, 10000u}) {
    if (quick && cubes > 1000) continue;
    cases.push_back({"stirred", {.cubes = cubes, .step_s = 1e-2, .stirred = true}});
  }
  // Last, because they depend on the cores: the counted program runs on one core and identifies a case by its index.
  constexpr std::size_t kMaxThreads = 8;
  for (std::uint32_t threads = 1; threads <= std::min(cores, kMaxThreads); ++threads)
    cases.push_back({.sweep = "threads", .pile = {.cubes = quick ? 1000u : 4000u, .step_s = 1e-2}, .threads = threads});
  for (ScalingCase& one : cases) {
    if (one.pile.cubes > 4000) one.timed_steps = 30;
    if (quick) {
      one.settle_s = 1;
      one.timed_steps = 30;
    }
  }
  return cases;
}

void run_counted(const ScalingCase& one, const EngineOptions& options) {
  const auto engine = settled(one, options, one.settle_s);
  start_counting();
  for (unsigned i = 0; i < kCountedSteps; ++i) engine->step();
  stop_counting();
}

ScalingReport run_scaling(const std::vector<ScalingCase>& cases, const EngineOptions& options,
                          const std::string& program, bool quick, const Progress& progress) {
  const std::vector<int> cores = loop::allowed_cpus();
  settle_on_core();
  ScalingReport report;
  const bool counts = !program.empty() && can_count_instructions();
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const auto say = [&](const char* doing) {
      if (progress)
        progress(
            fmt::format("{} of {}: {}, {} cubes, {}", i + 1, cases.size(), cases[i].sweep, cases[i].pile.cubes, doing));
    };
    say("timed");
    report.rows.push_back(timed(cases[i], options, cores));
    if (!counts || cases[i].threads > 0 || cases[i].pile.cubes > kCountedMost) continue;
    say("instructions");
    report.rows.back().instructions = counted(i, options, program, quick);
  }
  std::vector<double> points, us, instructions;
  for (const ScalingRow& row : report.rows)
    if (row.sweep == "bodies") {
      points.push_back(row.contact_points);
      us.push_back(row.median_us);
      instructions.push_back(row.instructions);
    }
  report.exponent = power_law_exponent(points, us);
  report.instruction_exponent = power_law_exponent(points, instructions);
  return report;
}

}  // namespace tactus::experiment
