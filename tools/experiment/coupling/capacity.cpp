#include "tools/experiment/coupling/capacity.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "sim/loader/scene_load.h"
#include "sim/model/choice_names.h"
#include "sim/model/step_settings.h"
#include "tools/experiment/coupling/coupled_worlds.h"
#include "tools/experiment/statistics.h"
#include "tools/experiment/timing.h"
#include "tools/session/find_description.h"

namespace tactus::experiment {
namespace {

constexpr unsigned kMinBodies = 25;
constexpr unsigned kMinSteps = 40;
// With five sub-steps in 10 ms, columns of eight cubes come to rest (3e-5 m/s), columns of twelve do not (1e-3 m/s).
constexpr unsigned kMaxLayers = 8;
// A heap above this multiple of its limit is not run again.
constexpr double kHopeless = 2;
constexpr double kSettle_s = 1.0, kPress_s = 0.2, kCube_m = 0.05, kProxyRadius_m = 0.02;
constexpr double kContact_Hz = 100;

// A heap as wide as high, up to eight layers, in its box, under a proxy: of at least `least` bodies, enough to fill the
// layer under the proxy. Contacts and sub-steps are those of sim/scenes/pile5000.toml.
Result<sim::Scene> make_heap(unsigned least, double rate_Hz) {
  const auto layers = std::clamp(static_cast<unsigned>(std::lround(std::cbrt(least / 2.0))), 1u, kMaxLayers);
  const unsigned bodies = (least + layers - 1) / layers * layers;
  const double top_m = kCube_m * layers + kProxyRadius_m + 5e-4;
  return sim::parse_scene(fmt::format(R"(
title = "A heap"
effects = ["gravity", "friction"]
[simulation]
contact_hertz_Hz = {}
sub_steps = {}
global_sub_steps_per_tick = 0.5
[device]
position_m = [0, -0.03, {}]
[proxy]
shape = "sphere"
radius_m = {}
mass_kg = 0.2
friction = 1.0
position_m = [0, -0.03, {}]
[[body]]
shape = "plane"
friction = 0.5
[[generate]]
kind = "pile"
count = {}
layers = {}
cube_m = {}
gap_fraction = 0.04
mass_kg = 0.075
friction = 0.5
wall_height_m = {}
wall_thickness_m = 0.05
[hand]
repeat = false
path = [{{time_s = 0.0, position_m = [0, -0.03, {}]}}]
)",
                                      kContact_Hz, sim::least_sub_steps(kContact_Hz, 1 / rate_Hz), top_m,
                                      kProxyRadius_m, top_m, bodies, layers, kCube_m, top_m + kCube_m, top_m),
                          "heap");
}

// Down by 12 mm in 0.1 s, then in circles.
haptics::DeviceTarget stir(const Vec3d& start, double time_s) {
  constexpr double kRadius_m = 0.02, kTurns_Hz = 1;
  const double pressed = std::min(1.0, time_s / 0.1);
  const double angle = 2 * std::numbers::pi * kTurns_Hz * time_s;
  haptics::DeviceTarget target;
  target.engaged = true;
  target.pose.position =
      start + Vec3d{kRadius_m * std::sin(angle), kRadius_m * (1 - std::cos(angle)), -0.012 * pressed};
  target.velocity.linear = Vec3d{std::cos(angle), std::sin(angle), 0} * (2 * std::numbers::pi * kTurns_Hz * kRadius_m);
  return target;
}

// Height of the settled heap below the proxy.
double top_below(const CoupledWorlds& worlds, const Vec3d& proxy) {
  double top_m = 0;
  const auto bodies = worlds.global() != nullptr ? worlds.global()->bodies() : worlds.sub_world().world().bodies();
  for (const auto& body : bodies) {
    const Vec3d off = body.motion.pose.position - proxy;
    const bool below = body.shape.kind == physics::ShapeKind::kBox && std::hypot(off.x, off.y) < kCube_m;
    if (below) top_m = std::max(top_m, body.motion.pose.position.z + 0.5 * kCube_m);
  }
  return top_m;
}

// Times of one heap, over its runs.
struct HeapTimes {
  OtherCore& of_global_world;
  std::vector<std::vector<double>> ticks_us{}, steps_us{};
};

// The ticks of a heap as a run has them: one in each period, while the other core computes the global step that began
// with the cycle.
class PacedTicks {
 public:
  PacedTicks(CoupledWorlds& worlds, OtherCore& of_global_world, double period_us)
      : worlds_(worlds), of_global_world_(of_global_world), period_us_(period_us) {}
  ~PacedTicks() { (void)end_global_step(); }
  PacedTicks(const PacedTicks&) = delete;
  PacedTicks& operator=(const PacedTicks&) = delete;

  // Waits for the global step that began last; its CPU time [us], none if none began since.
  std::optional<double> end_global_step() {
    if (!std::exchange(stepping_, false)) return std::nullopt;
    return of_global_world_.end();
  }
  // Waits for the next period; CPU time of the haptic side [us]. A global step that is due must have ended.
  double tick_us(const haptics::DeviceTarget& target) {
    while (wall_time_us() < next_us_) {}
    next_us_ = std::max(next_us_ + period_us_, wall_time_us());
    return timed_tick_us(worlds_, target, [this] {
      of_global_world_.begin([this] { worlds_.serve(); });
      stepping_ = true;
    });
  }

 private:
  CoupledWorlds& worlds_;
  OtherCore& of_global_world_;
  double period_us_, next_us_{0};
  bool stepping_{false};
};

// Runs the heap once more. Returns the point for the minimum times so far.
Result<CapacityPoint> time_heap(const CapacityRequest& request, CapacityPoint point, HeapTimes& times) {
  auto scene = make_heap(point.bodies, point.rate_Hz);
  if (!scene.ok()) return scene.status();
  const auto profile = session::find_description(scene.value().device.profile, {});
  if (!profile.ok()) return profile.status();
  session::RunOptions options;
  point.scheme.set(options);
  options.rate_Hz = point.rate_Hz;
  options.members = request.members;
  CoupledWorlds worlds(scene.value(), options, profile.value().properties);
  worlds.start_at_rest();
  Vec3d start = scene.value().bodies[scene.value().proxy].motion.pose.position;
  const auto rest = static_cast<unsigned>(std::lround(kSettle_s * point.rate_Hz));
  const auto settle = rest + static_cast<unsigned>(std::lround(kPress_s * point.rate_Hz));
  const unsigned timed =
      point.scheme.direct() ? request.ticks : std::max(request.ticks, kMinSteps * point.scheme.ratio);
  std::vector<double>& ticks_us = times.ticks_us.emplace_back();
  std::vector<double>& steps_us = times.steps_us.emplace_back();
  PacedTicks ticks(worlds, times.of_global_world, 1e6 / point.rate_Hz);
  for (unsigned k = 0; k < settle + timed; ++k) {
    std::optional<double> step_us;
    if (worlds.at_synchronisation() || k == rest) step_us = ticks.end_global_step();
    if (k == rest) start.z = top_below(worlds, start) + kProxyRadius_m;
    haptics::DeviceTarget target{true, {start, {}}, {}};
    if (k >= rest) target = stir(start, (k - rest) / point.rate_Hz);
    const double tick_us = ticks.tick_us(target);
    if (k < settle) continue;
    if (step_us) steps_us.push_back(*step_us);
    ticks_us.push_back(tick_us);
  }
  (void)ticks.end_global_step();
  point.contact_points = point.scheme.direct() ? worlds.last().report.points : worlds.global()->statistics().points;
  const double period_us = 1e6 / point.rate_Hz;
  const std::vector<double> tick_us = minimum_by_step(times.ticks_us), step_us = minimum_by_step(times.steps_us);
  point.tick_us_p50 = median(tick_us);
  point.tick_us_p99 = quantile(tick_us, 0.99);
  point.step_us_p50 = median(step_us);
  point.step_us_p90 = quantile(step_us, 0.9);
  point.tick_load = point.tick_us_p99 / period_us;
  point.step_load = point.step_us_p90 / (point.scheme.ratio * period_us);
  return point;
}

}  // namespace

Bracket find_capacity(unsigned least, unsigned most, const std::function<bool(unsigned)>& fits) {
  Bracket bracket;
  for (unsigned bodies = least; bodies <= most; bodies *= 2) {
    if (!fits(bodies)) {
      bracket.too_many = bodies;
      break;
    }
    bracket.fits = bodies;
  }
  if (bracket.fits == 0 || bracket.too_many == 0) return bracket;
  for (int halving = 0; halving < 3; ++halving) {
    const auto middle = static_cast<unsigned>(std::lround(std::sqrt(double{1} * bracket.fits * bracket.too_many)));
    (fits(middle) ? bracket.fits : bracket.too_many) = middle;
  }
  return bracket;
}

Result<CapacityReport> run_capacity(const CapacityRequest& request, const Progress& progress) {
  OtherCore of_global_world;
  settle_on_core();
  CapacityReport report;
  report.two_cores = of_global_world.there();
  report.members = request.members;
  report.runs = request.runs;
  // Each search counts as equal work: most of its time goes into its largest heaps.
  double work = 0, done = 0;
  for (const Scheme& scheme : request.couplings)
    work += static_cast<double>(request.rates_Hz.size()) *
            (scheme.direct() ? 1.0 : static_cast<double>(request.ratios.size()));
  const WorkProgress pace(progress, work);
  for (const double rate_Hz : request.rates_Hz) {
    unsigned direct_bodies = 0;
    for (Scheme scheme : request.couplings) {
      for (const unsigned ratio : scheme.direct() ? std::vector<unsigned>{1} : request.ratios) {
        scheme.ratio = ratio;
        CapacityRow row{.scheme = scheme, .rate_Hz = rate_Hz, .bodies = 0, .too_many = 0, .breaks = {}, .quotient = 0};
        Status failed = Status::good();
        const auto fits = [&](unsigned bodies) {
          if (!failed.ok()) return false;
          pace.say(
              fmt::format("{} at {:g} Hz, ratio {}: {} bodies", sim::name_of(scheme.coupling), rate_Hz, ratio, bodies),
              done);
          CapacityPoint point;
          point.scheme = scheme;
          point.rate_Hz = rate_Hz;
          point.bodies = bodies;
          HeapTimes times{of_global_world};
          while (times.ticks_us.size() < request.runs) {
            const auto timed = time_heap(request, point, times);
            if (!timed.ok()) failed = timed.status();
            if (!timed.ok()) return false;
            point = timed.value();
            if (point.fits() || point.load() > kHopeless) break;
          }
          report.points.push_back(point);
          if (!point.fits()) row.breaks = point.step_load > 1 ? "global step" : "tick";
          return point.fits();
        };
        const Bracket bracket = find_capacity(kMinBodies, request.most_bodies, fits);
        if (!failed.ok()) return failed;
        row.bodies = bracket.fits;
        row.too_many = bracket.too_many;
        if (scheme.direct()) direct_bodies = bracket.fits;
        if (direct_bodies > 0) row.quotient = static_cast<double>(row.bodies) / direct_bodies;
        report.rows.push_back(row);
        done += 1;
      }
    }
  }
  return report;
}

}  // namespace tactus::experiment
