#include "tools/experiment/coupling/coupling_study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "rt/base/denormals.h"
#include "tools/experiment/coupling/force_measures.h"
#include "tools/experiment/coupling/reference_run.h"
#include "tools/experiment/statistics.h"
#include "tools/session/find_description.h"
#include "tools/session/scheme_gains.h"
#include "tools/session/session.h"

namespace tactus::experiment {
namespace {

constexpr double kApart_m = 1e-6;
constexpr double kVibrationLow_Hz = 20, kVibrationHigh_Hz = 500;

std::vector<unsigned> ratios_of(const StudyRequest& request) {
  std::vector<unsigned> ratios;
  for (const Scheme& scheme : request.schemes) ratios.push_back(scheme.ratio);
  std::sort(ratios.begin(), ratios.end());
  ratios.erase(std::unique(ratios.begin(), ratios.end()), ratios.end());
  return ratios;
}

// Sums for a row, over windows and seeds.
struct RowSums {
  ForceError hold, moving;
  double worst{0};
  EnergyDeviation energy;
  std::vector<double> steps, vibration, encoder_vibration;
  std::vector<double> spectrum;
  std::size_t spectra{0};

  ForceError all() const {
    ForceError sum = hold;
    sum.add(moving);
    return sum;
  }
  void add(const RowSums& other);
};

void append(std::vector<double>& to, const std::vector<double>& from) { to.insert(to.end(), from.begin(), from.end()); }

void RowSums::add(const RowSums& other) {
  hold.add(other.hold);
  moving.add(other.moving);
  energy.add(other.energy);
  worst = std::max(worst, other.worst);
  append(steps, other.steps);
  append(vibration, other.vibration);
  append(encoder_vibration, other.encoder_vibration);
  spectrum.resize(std::max(spectrum.size(), other.spectrum.size()));
  for (std::size_t i = 0; i < other.spectrum.size(); ++i) spectrum[i] += other.spectrum[i];
  spectra += other.spectra;
}

SeedFigures figures_of(const RowSums& sums) {
  const Deviation energy = sums.energy.kinetic();
  return {.force_error = sums.all().relative(),
          .loss = energy.loss,
          .gain = energy.gain,
          .sync_step_N = quantile(sums.steps, 0.95),
          .hold_vibration_N = median(sums.vibration)};
}

// Schemes with the same gains, and the scene with these gains.
struct GainsGroup {
  haptics::CouplingGains gains;
  std::vector<std::size_t> schemes;  // in the request's order
  HandInLoop direct_loop;
};

// Measurement of one scene.
class SceneStudy {
 public:
  SceneStudy(const StudyRequest& request, const CouplingCase& one, const hal::DeviceProfile& profile)
      : request_(request),
        case_(one),
        profile_(profile),
        ratios_(ratios_of(request)),
        sums_(request.schemes.size()),
        by_seed_(request.schemes.size()) {}

  Status measure(std::uint64_t seed);
  Status judge_stability();
  Status judge_poses();
  void add_to(StudyReport& report) const;

 private:
  void group_schemes(const sim::Scene& scene);
  void measure_group(const GainsGroup& group, bool scenes_own);
  session::RunOptions options(const Scheme& scheme) const;
  CoupledWorlds worlds(const Scheme& scheme) const { return {scene_, options(scheme), profile_.properties}; }
  ScriptedArm arm() const {
    const auto config = session::loop_config(scene_, options(kDirectScheme), profile_.properties);
    return {profile_, session::make_hand(scene_), config.placement, config.period_s};
  }
  void measure_apart(const ReferenceRun& reference, const Window& window);
  void measure_scheme(std::size_t index, const ReferenceRun& reference, const Window& window,
                      std::span<const Vec3d> direct_encoded);
  void start(CoupledWorlds& worlds, const Scheme& scheme, const ReferenceRun& reference, const Window& window) const;

  HandInLoop close_loop(const Scheme& scheme) const;

  const StudyRequest& request_;
  const CouplingCase& case_;
  const hal::DeviceProfile& profile_;
  std::vector<unsigned> ratios_;
  sim::Scene scene_;                  // with the hand of the last seed and the gains of the current group
  haptics::CouplingGains own_gains_;  // the scene's
  std::vector<GainsGroup> groups_;    // the scene's own gains first
  std::vector<RowSums> sums_;         // over the finished seeds
  std::vector<RowSums> seed_sums_;    // of the current seed
  std::vector<std::vector<SeedFigures>> by_seed_;
  std::vector<HandInLoop> loops_;
  StudyScene account_;
  ForceError apart_;
  EnergyDeviation apart_energy_;
  double touching_{0}, ticks_{0}, force_squared_{0};
};

session::RunOptions SceneStudy::options(const Scheme& scheme) const {
  session::RunOptions options;
  scheme.set(options);
  options.members = request_.members > 0 ? request_.members : case_.members;
  options.order = request_.order;
  options.rate_Hz = kHapticRate_Hz;
  options.virtual_time = true;
  return options;
}

void SceneStudy::group_schemes(const sim::Scene& scene) {
  const auto gains = [&](const Scheme& scheme) {
    return session::gains_of(scene, options(scheme), profile_.properties).gains;
  };
  own_gains_ = gains(kDirectScheme);
  groups_ = {{own_gains_, {}, {}}};
  for (std::size_t i = 0; i < request_.schemes.size(); ++i) {
    const haptics::CouplingGains wanted = gains(request_.schemes[i]);
    auto at = std::find_if(groups_.begin(), groups_.end(), [&](const GainsGroup& g) { return g.gains == wanted; });
    if (at == groups_.end()) at = groups_.insert(at, {wanted, {}, {}});
    at->schemes.push_back(i);
  }
}

Status SceneStudy::measure(std::uint64_t seed) {
  auto loaded = load_coupling_case(case_, seed);
  if (!loaded.ok()) return loaded.status();
  scene_ = std::move(loaded).value();
  if (groups_.empty()) group_schemes(scene_);
  seed_sums_.assign(request_.schemes.size(), {});
  for (const GainsGroup& group : groups_) {
    scene_.coupling = group.gains;
    measure_group(group, &group == &groups_.front());
  }
  for (std::size_t i = 0; i < sums_.size(); ++i) {
    by_seed_[i].push_back(figures_of(seed_sums_[i]));
    sums_[i].add(seed_sums_[i]);
  }
  return Status::good();
}

void SceneStudy::measure_group(const GainsGroup& group, bool scenes_own) {
  CoupledWorlds direct = worlds(kDirectScheme);
  ScriptedArm hand = arm();
  const auto at = window_places(request_.quick);
  const ReferenceRun reference = record_reference(direct, hand, tick_at(HandTimes::kEnd), at, ratios_);
  account_.bodies = static_cast<unsigned>(direct.sub_world().members());
  if (scenes_own) account_.contact_points = std::max(account_.contact_points, reference.most_points);
  for (const Window& window : reference.windows) {
    for (std::size_t k = window.start; scenes_own && k < window.start + kWindowTicks; ++k) {
      touching_ += reference.touches[k];
      ticks_ += 1;
      force_squared_ += norm_squared(reference.force[k]);
    }
    std::vector<Vec3d> encoded;
    if (window.hold) {
      start(direct, kDirectScheme, reference, window);
      encoded = run_window(direct, reference.encoded, reference, window, kLongestWindow, nullptr);
    }
    if (scenes_own) measure_apart(reference, window);
    for (const std::size_t i : group.schemes) measure_scheme(i, reference, window, encoded);
  }
}

void SceneStudy::start(CoupledWorlds& worlds, const Scheme& scheme, const ReferenceRun& reference,
                       const Window& window) const {
  const auto found = std::find(ratios_.begin(), ratios_.end(), scheme.ratio);
  const WorldKeyframe nothing;
  const WorldKeyframe& before =
      found == ratios_.end() ? nothing : window.before[static_cast<std::size_t>(found - ratios_.begin())];
  worlds.start_from(before, window.now, reference.mean_on_proxy(window.start, scheme.ratio));
}

void SceneStudy::measure_apart(const ReferenceRun& reference, const Window& window) {
  CoupledWorlds apart = worlds(kDirectScheme);
  apart.start_from({}, window.now, {}, {kApart_m, 0, 0});
  const auto force =
      run_window(apart, reference.ideal, reference, window, kWindowTicks, window.hold ? nullptr : &apart_energy_);
  apart_.add(force, std::span(reference.force).subspan(window.start, kWindowTicks));
}

void SceneStudy::measure_scheme(std::size_t index, const ReferenceRun& reference, const Window& window,
                                std::span<const Vec3d> direct_encoded) {
  const Scheme& scheme = request_.schemes[index];
  RowSums& sums = seed_sums_[index];
  const std::size_t ticks = window_ticks(scheme.ratio);
  const auto wanted = std::span(reference.force).subspan(window.start, ticks);
  CoupledWorlds tested = worlds(scheme);
  start(tested, scheme, reference, window);
  const auto force =
      run_window(tested, reference.ideal, reference, window, ticks, window.hold ? nullptr : &sums.energy);
  account_.component = std::max(account_.component, tested.component());

  ForceError error;
  error.add(force, wanted);
  (window.hold ? sums.hold : sums.moving).add(error);
  sums.worst = std::max(sums.worst, error.relative());
  std::vector<std::size_t> syncs;
  for (std::size_t k = scheme.ratio; k < ticks; k += scheme.ratio) syncs.push_back(k);
  const auto steps = steps_at(force, wanted, syncs);
  sums.steps.insert(sums.steps.end(), steps.begin(), steps.end());
  if (!window.hold) return;

  const auto off = difference(force, wanted);
  sums.vibration.push_back(band_deviation(off, kHapticRate_Hz, kVibrationLow_Hz, kVibrationHigh_Hz));
  const auto lines = power_spectrum(std::span(off).last(kWindowTicks));  // the same lines at every ratio
  sums.spectrum.resize(lines.size());
  for (std::size_t i = 0; i < lines.size(); ++i) sums.spectrum[i] += lines[i];
  ++sums.spectra;
  CoupledWorlds with_encoder = worlds(scheme);
  start(with_encoder, scheme, reference, window);
  const auto encoded = run_window(with_encoder, reference.encoded, reference, window, ticks, nullptr);
  sums.encoder_vibration.push_back(
      band_deviation(difference(encoded, direct_encoded), kHapticRate_Hz, kVibrationLow_Hz, kVibrationHigh_Hz));
}

HandInLoop SceneStudy::close_loop(const Scheme& scheme) const {
  CoupledWorlds tested = worlds(scheme);
  ScriptedArm hand = arm();
  tested.start_at_rest();
  HandInLoop loop;
  std::vector<Vec3d> held;
  Wrenchd on_device;
  const std::size_t first_held = tick_at(HandTimes::kHeld) - 500, last_held = tick_at(HandTimes::kHeld);
  for (std::size_t k = 0; k < tick_at(HandTimes::kEnd); ++k) {
    if (k > 0) hand.advance(on_device);
    on_device = tested.tick(hand.encoded()).on_device;
    const double size = norm(on_device.force);
    // A force beyond that of any device is not used further.
    if (!is_finite(on_device) || size > 1e3)
      return {.peak_N = 1e3, .shake_N = 1e3, .hold_N = 1e3, .fallen = 0, .energy_gain = 0};
    loop.peak_N = std::max(loop.peak_N, size);
    if (k < first_held || k >= last_held) continue;
    held.push_back(on_device.force);
    loop.hold_N += size / static_cast<double>(last_held - first_held);
  }
  loop.shake_N = band_deviation(held, kHapticRate_Hz, kVibrationLow_Hz, kVibrationHigh_Hz);
  return loop;
}

// Repeats the runs and compares poses and energy of all bodies with the direct run's (whole_run.h).
Status SceneStudy::judge_poses() {
  scene_.coupling = own_gains_;
  WholeRunRequest whole;
  whole.scenes = {scene_};
  whole.schemes = request_.schemes;
  whole.members = {options(kDirectScheme).members};
  whole.seconds = HandTimes::kEnd;
  whole.order = request_.order;
  const auto rows = run_whole(whole, {});
  if (!rows.ok()) return rows.status();
  for (std::size_t i = 0; i < loops_.size(); ++i) {
    const WholeRunRow& row = rows.value()[i];
    loops_[i].fallen = row.fallen;
    loops_[i].energy_gain = (row.energy_gain_J - row.direct_energy_gain_J) / row.energy_at_play_J;
  }
  return Status::good();
}

Status SceneStudy::judge_stability() {
  loops_.resize(request_.schemes.size());
  for (GainsGroup& group : groups_) {
    scene_.coupling = group.gains;
    group.direct_loop = close_loop(kDirectScheme);
    for (const std::size_t i : group.schemes) loops_[i] = close_loop(request_.schemes[i]);
  }
  return judge_poses();
}

void SceneStudy::add_to(StudyReport& report) const {
  StudyScene account = account_;
  account.name = case_.name;
  account.members = options(kDirectScheme).members;
  account.contact_share = touching_ / ticks_;
  account.force_rms_N = std::sqrt(force_squared_ / ticks_);
  account.apart_force_error = apart_.relative();
  account.apart_energy = apart_energy_.kinetic();
  account.loop = groups_.front().direct_loop;
  report.scenes.push_back(account);
  for (std::size_t i = 0; i < request_.schemes.size(); ++i) {
    const RowSums& sums = sums_[i];
    const auto group = std::find_if(groups_.begin(), groups_.end(), [i](const GainsGroup& g) {
      return std::find(g.schemes.begin(), g.schemes.end(), i) != g.schemes.end();
    });
    StudyRow row;
    row.gains = group->gains;
    row.lowered = !(group->gains == own_gains_);
    row.scene = case_.name;
    row.scheme = request_.schemes[i];
    row.members = account.members;
    row.at_rest = sums.energy.at_rest();
    row.energy = sums.energy.kinetic();
    row.worst_instant = sums.energy.worst_instant();
    row.speed_squared = sums.energy.speed_squared();
    row.force_error = sums.all().relative();
    row.by_seed = by_seed_[i];
    row.force_error_hold = sums.hold.relative();
    row.force_error_moving = sums.moving.relative();
    row.force_error_worst = sums.worst;
    row.sync_step_N = quantile(sums.steps, 0.95);
    row.hold_vibration_N = median(sums.vibration);
    row.hold_vibration_worst_N = quantile(sums.vibration, 1);
    row.hold_vibration_encoder_N = median(sums.encoder_vibration);
    row.loop = loops_[i];
    row.stable = is_stable(loops_[i], group->direct_loop);
    for (const double power : sums.spectrum) row.spectrum.push_back(power / static_cast<double>(sums.spectra));
    report.rows.push_back(std::move(row));
  }
}

}  // namespace

bool is_stable(const HandInLoop& loop, const HandInLoop& direct) {
  return loop.peak_N <= 1.5 * direct.peak_N + 1.0 && loop.shake_N <= direct.shake_N + 0.2 &&
         loop.hold_N >= 0.5 * direct.hold_N && loop.fallen == 0 && loop.energy_gain <= kMaxEnergyGain;
}

Result<StudyReport> run_coupling_study(const StudyRequest& request, const Progress& progress) {
  set_denormals_flush();
  StudyReport report;
  report.seeds = request.seeds;
  report.windows = static_cast<unsigned>(window_places(request.quick).size());
  report.window_s = kWindowTicks / kHapticRate_Hz;
  report.line_Hz = line_Hz(1, kWindowTicks, kHapticRate_Hz);
  std::vector<double> weight;
  double work = 0, done = 0;
  for (const CouplingCase& one : request.cases) {
    auto scene = load_coupling_case(one, 0);
    if (!scene.ok()) return scene.status();
    if (const unsigned moving = scene.value().moving_bodies(); moving > haptics::kMaxMembers)
      return Status::error(
          fmt::format("{}: {} bodies move, and a window starts with all of them in the sub-world; accepted: up to {}; "
                      "--seeds 0 --whole 10 runs the scene without windows",
                      one.name, moving, haptics::kMaxMembers));
    weight.push_back(static_cast<double>(scene.value().bodies.size()));
    work += (request.seeds + 1) * weight.back();
  }
  const WorkProgress pace(progress, work);  // scenes are weighted by their number of bodies
  for (std::size_t c = 0; c < request.cases.size(); ++c) {
    const CouplingCase& one = request.cases[c];
    auto scene = load_coupling_case(one, 0);
    const auto profile = session::find_description(scene.value().device.profile, {});
    if (!profile.ok()) return profile.status();
    SceneStudy study(request, one, profile.value());
    for (unsigned seed = request.seeds;
         seed-- > 0;) {  // the unmodified hand (seed 0) last, because stability is tested with it
      pace.say(fmt::format("scene {}, seed {} of {}", one.name, request.seeds - seed, request.seeds), done);
      if (const Status status = study.measure(seed); !status.ok()) return status;
      done += weight[c];
    }
    pace.say(fmt::format("scene {}, stability", one.name), done);
    if (const Status status = study.judge_stability(); !status.ok()) return status;
    done += weight[c];
    study.add_to(report);
  }
  return report;
}

}  // namespace tactus::experiment
