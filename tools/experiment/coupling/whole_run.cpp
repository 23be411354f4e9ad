#include "tools/experiment/coupling/whole_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <list>

#include "rt/base/denormals.h"
#include "sim/model/choice_names.h"
#include "tools/experiment/coupling/force_measures.h"
#include "tools/experiment/coupling/reference_run.h"
#include "tools/session/find_description.h"
#include "tools/session/scheme_gains.h"
#include "tools/session/session.h"

namespace tactus::experiment {
namespace {

using physics::Body;

// Poses are compared at a multiple of every ratio that is accepted for this, so that each run is at a synchronisation.
constexpr unsigned kCompareEvery = 16 * 5;
// Work below this counts as 0: the energy at play is then the weight term alone.
constexpr double kMinWork_J = 1e-6;
// Beyond the force of any device: the run counts as lost and ends there.
constexpr double kLostForce_N = 1e4;

double smallest_extent(const physics::Shape& shape) {
  using enum physics::ShapeKind;
  switch (shape.kind) {
    case kSphere:
    case kCapsule:
      return 2 * shape.radius;
    case kBox:
    case kCylinder:
    case kCone:
    case kHull:
    case kCompound:
    case kPlane:
    case kMesh:
      break;
  }
  return 2 * std::min({shape.half_extents.x, shape.half_extents.y, shape.half_extents.z});
}

double turned(const Body& a, const Body& b) {
  return norm(small_rotation_vector(a.motion.pose.rotation * conjugate(b.motion.pose.rotation)));
}

double off(const Body& a, const Body& b) { return norm(a.motion.pose.position - b.motion.pose.position); }

// Bodies after `comparison` times kCompareEvery ticks.
struct PosesAt {
  std::size_t comparison;
  std::vector<Body> bodies;
};

// Recording of one run, tick by tick, for the comparison and the direct run.
struct Trace {
  std::vector<Vec3d> force;
  std::vector<haptics::DeviceTarget> target;
  std::vector<PosesAt> poses;
  std::vector<Body> end;
  double deepest_m{0}, kinetic_J{0}, kinetic_over_work{0}, gain_J{0}, rise_J{0}, unexplained_J{0}, work_J{0};
  EnergyAccount account;
  bool lost{false};
};

double potential_J(std::span<const Body> bodies, const Vec3d& gravity) {
  double sum = 0;
  for (const auto& body : bodies) sum -= body.mass * body.gravity_scale * dot(gravity, body.motion.pose.position);
  return sum;
}

double kinetic_J(std::span<const Body> bodies) {
  double sum = 0;
  for (const auto& body : bodies) sum += kinetic_energy(body);
  return sum;
}

using Targets = std::span<const haptics::DeviceTarget>;

// Targets of a device that is not engaged.
std::vector<haptics::DeviceTarget> no_device(double seconds) {
  return std::vector<haptics::DeviceTarget>(tick_at(seconds));
}

class WholeRun {
 public:
  WholeRun(const sim::Scene& scene, const hal::DeviceProfile& profile, double seconds, sim::CutOrder order)
      : scene_(scene), profile_(profile), seconds_(seconds), order_(order) {
    double fall = 0;
    for (const auto& body : scene.bodies)
      if (body.kind == physics::BodyKind::kDynamic)
        fall += body.mass * body.gravity_scale * norm(scene.gravity_m_per_s2) * smallest_extent(body.shape);
    weight_J_ = fall;
  }

  double weight_J() const { return weight_J_; }

  session::RunOptions options(const Scheme& scheme, unsigned members) const {
    session::RunOptions options;
    scheme.set(options);
    options.members = members > 0 ? members : scene_.members;
    options.order = order_;
    options.rate_Hz = kHapticRate_Hz;
    options.virtual_time = true;
    return options;
  }

  // `targets`: of another run's hand; empty: the run's own arm in the loop.
  Trace run(const Scheme& scheme, unsigned members, Targets targets) const {
    const auto chosen = options(scheme, members);
    CoupledWorlds worlds(scene_, chosen, profile_.properties);
    const auto config = session::loop_config(scene_, chosen, profile_.properties);
    ScriptedArm arm(profile_, session::make_hand(scene_), config.placement, config.period_s);
    worlds.start_at_rest();
    Trace trace;
    std::vector<Body> bodies;
    worlds.bodies(bodies);
    const double start_J = potential_J(bodies, scene_.gravity_m_per_s2) + kinetic_J(bodies);
    const double start_potential_J = potential_J(bodies, scene_.gravity_m_per_s2);
    double work_J = 0, work_size_J = 0, least_J = start_J, least_with_stores_J = start_J;
    std::size_t spent_ticks = 0;
    Twistd before = worlds.sub_world().proxy().velocity;
    const std::size_t ticks = tick_at(seconds_);
    for (std::size_t k = 0; k < ticks; ++k) {
      if (k > 0 && targets.empty()) arm.advance(on_device_);
      trace.target.push_back(targets.empty() ? arm.encoded() : targets[k]);
      const bool all_at_one_time = worlds.at_synchronisation();
      if (all_at_one_time) {
        worlds.bodies(bodies);
        const double kinetic = kinetic_J(bodies), potential = potential_J(bodies, scene_.gravity_m_per_s2);
        const double released = std::max(0.0, start_potential_J - potential);
        trace.kinetic_J = std::max(trace.kinetic_J, kinetic);
        trace.kinetic_over_work =
            std::max(trace.kinetic_over_work, kinetic / std::max(kMinWork_J, work_size_J + released));
        const double beyond_work_J = kinetic + potential - work_J;
        least_J = std::min(least_J, beyond_work_J);
        least_with_stores_J =
            std::min(least_with_stores_J, beyond_work_J + worlds.springs_J() + worlds.held_by_border_J());
        trace.gain_J = std::max(trace.gain_J, beyond_work_J - start_J);
        trace.rise_J = std::max(trace.rise_J, beyond_work_J - least_J);
        trace.unexplained_J = std::max(trace.unexplained_J, beyond_work_J - least_with_stores_J);
        if (k % kCompareEvery == 0) trace.poses.push_back({k / kCompareEvery, bodies});
      }
      const haptics::SubWorldStep& step = worlds.tick(trace.target.back());
      on_device_ = step.on_device;
      trace.force.push_back(step.on_device.force);
      if ((step.status & kBorderSpent) != 0) ++spent_ticks;
      trace.deepest_m = std::max(trace.deepest_m, step.report.deepest_m);
      if (!is_finite(on_device_) || norm(on_device_.force) > kLostForce_N) {
        trace.lost = true;
        break;
      }
      const Twistd& now = worlds.sub_world().proxy().velocity;
      const Vec3d mean = 0.5 * (before.linear + now.linear), turn = 0.5 * (before.angular + now.angular);
      const double work = -(dot(on_device_.force, mean) + dot(on_device_.torque, turn)) / kHapticRate_Hz;
      work_J += work;
      work_size_J += std::abs(work);
      before = now;
    }
    on_device_ = {};
    worlds.bodies(trace.end);
    trace.work_J = work_size_J;
    const haptics::SubWorld& sub_world = worlds.sub_world();
    trace.account = {.device_J = work_J,
                     .border_work_J = sub_world.border_work_J() + sub_world.push_out_J(),
                     .corrected_J = sub_world.corrected_J(),
                     .tank_J = sub_world.border_tank_J(),
                     .spent_share = static_cast<double>(spent_ticks) / static_cast<double>(trace.force.size())};
    if (worlds.global() != nullptr) {
      const sim::GlobalStatistics& global = worlds.global()->statistics();
      trace.deepest_m = std::max(trace.deepest_m, global.deepest_m);
      trace.account.global_work_J = global.border_work_J;
      trace.account.imposed_J = global.imposed_energy_J;
      trace.account.returned_J = global.returned_energy_J;
    }
    return trace;
  }

 private:
  const sim::Scene& scene_;
  const hal::DeviceProfile& profile_;
  double seconds_;
  sim::CutOrder order_;
  double weight_J_{0};
  mutable Wrenchd on_device_;
};

void compare_force(const Trace& run, const Trace& direct, WholeRunRow& row) {
  const std::size_t n = direct.force.size();
  std::vector<Vec3d> force = run.force;
  force.resize(n);  // a lost run has zero force from there on
  ForceError whole;
  for (std::size_t q = 0; q < 4; ++q) {
    const std::size_t from = q * n / 4, to = (q + 1) * n / 4;
    ForceError quarter;
    quarter.add(std::span(force).subspan(from, to - from), std::span(direct.force).subspan(from, to - from));
    row.force_error_quarter[q] =
        std::sqrt(quarter.error_squared / static_cast<double>(std::max<std::size_t>(1, to - from)));
    whole.add(quarter);
  }
  row.force_error = whole.relative();
  row.force_rms_N = std::sqrt(whole.reference_squared / static_cast<double>(n));
  for (double& quarter : row.force_error_quarter) quarter = row.force_rms_N > 0 ? quarter / row.force_rms_N : 0;
}

double farthest(std::span<const Body> a, std::span<const Body> b) {
  double most = 0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) most = std::max(most, off(a[i], b[i]));
  return most;
}

bool turned_over(const Body& a, const Body& b) {
  return a.shape.kind != physics::ShapeKind::kSphere && turned(a, b) >= StandingRule::kTurnedOver_rad;
}

bool has_fallen(const Body& start, const Body& end, double extent) {
  const double sunk = start.motion.pose.position.z - end.motion.pose.position.z;
  return sunk > StandingRule::kShareOfExtent * extent || turned_over(start, end);
}

void compare_poses(const Trace& run, const Trace& direct, WholeRunRow& row) {
  row.pose_off_m = farthest(run.end, direct.end);
  row.pose_off_most_m = row.pose_off_m;
  // Poses of the run are known at its synchronisations, those of the direct run at every comparison.
  const auto off_at = [&](const PosesAt& at) { return farthest(at.bodies, direct.poses[at.comparison].bodies); };
  std::size_t compared = 0;
  while (compared < run.poses.size() && run.poses[compared].comparison < direct.poses.size()) ++compared;
  for (const PosesAt& at : std::span(run.poses).first(compared))
    row.pose_off_most_m = std::max(row.pose_off_most_m, off_at(at));
  if (compared > 0) row.drift_m = row.pose_off_m - off_at(run.poses[compared * 3 / 4]);
  const Standing standing = judge_standing(direct.poses.front().bodies, direct.end, run.end);
  row.standing = standing.standing;
  row.fallen = static_cast<unsigned>(standing.fell.size());
  row.pose_off_share = standing.most_off_share;
  row.stands = row.fallen == 0 && !run.lost;
}

WholeRunRow row_of(const WholeRun& whole, const Trace& run, const Trace& direct) {
  WholeRunRow row;
  compare_force(run, direct, row);
  compare_poses(run, direct, row);
  row.deepest_m = run.deepest_m;
  row.direct_deepest_m = direct.deepest_m;
  row.kinetic_J = run.kinetic_J;
  row.kinetic_over_work = run.kinetic_over_work;
  row.energy_gain_J = run.gain_J;
  row.direct_energy_gain_J = direct.gain_J;
  row.energy_rise_J = run.rise_J;
  row.direct_energy_rise_J = direct.rise_J;
  row.energy_unexplained_J = run.unexplained_J;
  row.direct_energy_unexplained_J = direct.unexplained_J;
  row.energy_at_play_J = direct.work_J + whole.weight_J();
  row.direct_kinetic_J = direct.kinetic_J;
  row.account = run.account;
  return row;
}

sim::Scene with_gains(sim::Scene scene, const haptics::CouplingGains& gains) {
  scene.coupling = gains;
  return scene;
}

// The reference of a scheme: the direct coupling with the same gains.
class DirectRun {
 public:
  DirectRun(const sim::Scene& scene, const haptics::CouplingGains& gains, const hal::DeviceProfile& profile,
            const WholeRunRequest& request, bool with_hand = true)
      : gains_(gains),
        with_hand_(with_hand),
        scene_(with_gains(scene, gains)),
        whole_(scene_, profile, request.seconds, request.order),
        trace_(whole_.run(kDirectScheme, 0, with_hand ? Targets{} : no_device(request.seconds))) {}
  DirectRun(const DirectRun&) = delete;  // whole_ refers to scene_
  DirectRun& operator=(const DirectRun&) = delete;

  const haptics::CouplingGains& gains() const { return gains_; }
  bool with_hand() const { return with_hand_; }
  const WholeRun& whole() const { return whole_; }
  const Trace& trace() const { return trace_; }

 private:
  haptics::CouplingGains gains_;
  bool with_hand_;
  sim::Scene scene_;
  WholeRun whole_;
  Trace trace_;
};

// The references of one scene: each is run when it is asked for first.
class DirectRuns {
 public:
  DirectRuns(const sim::Scene& scene, const hal::DeviceProfile& profile, const WholeRunRequest& request)
      : scene_(scene), profile_(profile), request_(request) {}

  const DirectRun& of(const haptics::CouplingGains& gains, bool with_hand) {
    for (const DirectRun& run : runs_)
      if (run.gains() == gains && run.with_hand() == with_hand) return run;
    return runs_.emplace_back(scene_, gains, profile_, request_, with_hand);
  }

 private:
  const sim::Scene& scene_;
  const hal::DeviceProfile& profile_;
  const WholeRunRequest& request_;
  std::list<DirectRun> runs_;  // their addresses stay
};

// The direct run of `other` beside the direct run `own`.
WholeRunRow direct_row(const sim::Scene& other, const DirectRun& own, const hal::DeviceProfile& profile,
                       const WholeRunRequest& request) {
  const DirectRun run(other, own.gains(), profile, request);
  WholeRunRow row = row_of(own.whole(), run.trace(), own.trace());
  row.scene = other.name;
  row.scheme = kDirectScheme;
  row.seconds = request.seconds;
  row.members = static_cast<unsigned>(own.trace().end.size());
  row.gains = own.gains();
  return row;
}

void add_floor(const sim::Scene& scene, const DirectRun& own, const hal::DeviceProfile& profile,
               const WholeRunRequest& request, std::vector<WholeRunRow>& rows) {
  sim::Scene other = scene;
  other.bodies[other.proxy].motion.pose.position.x += WholeRunRequest::kApart_m;
  rows.push_back(direct_row(other, own, profile, request));
  rows.back().apart_m = WholeRunRequest::kApart_m;
  rows.push_back(direct_row(with_finer_steps(scene, WholeRunRequest::kFinerSteps), own, profile, request));
  rows.back().sub_steps_times = WholeRunRequest::kFinerSteps;
}

}  // namespace

std::string_view name_of(WholeRunHand hand) noexcept {
  switch (hand) {
    case WholeRunHand::kClosed:
      return "closed";
    case WholeRunHand::kDirect:
      return "direct";
    case WholeRunHand::kNone:
      return "none";
  }
  return {};
}

sim::Scene with_finer_steps(sim::Scene scene, unsigned times) {
  scene.solver.sub_steps *= times;
  return scene;
}

Standing judge_standing(std::span<const Body> start, std::span<const Body> direct_end, std::span<const Body> end) {
  Standing result;
  for (std::size_t i = 0; i < std::min(end.size(), direct_end.size()); ++i) {
    if (norm(direct_end[i].motion.velocity.linear) > StandingRule::kAtRest_m_per_s) continue;
    const double extent = smallest_extent(direct_end[i].shape);
    if (has_fallen(start[i], direct_end[i], extent)) continue;
    ++result.standing;
    const double share = off(end[i], direct_end[i]) / extent;
    if (!is_finite(end[i].motion.pose)) {
      result.most_off_share = std::numeric_limits<double>::infinity();
      result.fell.push_back(end[i].id);
      continue;
    }
    result.most_off_share = std::max(result.most_off_share, share);
    if (share > StandingRule::kShareOfExtent || turned_over(end[i], direct_end[i])) result.fell.push_back(end[i].id);
  }
  return result;
}

Result<std::vector<WholeRunRow>> run_whole(const WholeRunRequest& request, const Progress& progress) {
  set_denormals_flush();
  std::vector<WholeRunRow> rows;
  double work = 0, done = 0;
  for (const sim::Scene& scene : request.scenes)
    work += static_cast<double>(scene.bodies.size() *
                                ((request.floor ? 4 : 1) + request.schemes.size() * request.members.size()));
  const WorkProgress pace(progress, work);
  for (const sim::Scene& scene : request.scenes) {
    const auto profile = session::find_description(scene.device.profile, {});
    if (!profile.ok()) return profile.status();
    pace.say(fmt::format("scene {}, direct", scene.name), done);
    const WholeRun whole(scene, profile.value(), request.seconds, request.order);
    DirectRuns direct_runs(scene, profile.value(), request);
    if (request.floor) add_floor(scene, direct_runs.of(scene.coupling, true), profile.value(), request, rows);
    done += static_cast<double>(scene.bodies.size() * (request.floor ? 4 : 1));
    for (const unsigned members : request.members)
      for (const Scheme& scheme : request.schemes) {
        pace.say(fmt::format("scene {}, ratio {}", scene.name, scheme.ratio), done);
        const session::RunOptions options = whole.options(scheme, members);
        const haptics::DeviceProperties& device = profile.value().properties;
        if (!scheme.direct()) {
          const Status status = sim::check_global_options(scene, session::global_options(scene, options, device));
          if (!status.ok()) return status;
        }
        const haptics::CouplingGains gains = session::gains_of(scene, options, device).gains;
        for (const WholeRunHand hand : request.hands) {
          const DirectRun& direct = direct_runs.of(gains, hand != WholeRunHand::kNone);
          const auto targets = hand == WholeRunHand::kClosed ? Targets{} : Targets{direct.trace().target};
          Trace run = direct.whole().run(scheme, members, targets);
          WholeRunRow row = row_of(direct.whole(), run, direct.trace());
          row.scene = scene.name;
          row.scheme = scheme;
          row.seconds = request.seconds;
          row.hand = hand;
          row.members = members > 0 ? members : scene.members;
          row.gains = gains;
          if (request.keep_bodies) {
            row.start = direct.trace().poses.front().bodies;
            row.direct_end = direct.trace().end;
            row.end = std::move(run.end);
          }
          rows.push_back(std::move(row));
        }
        done += static_cast<double>(scene.bodies.size());
      }
  }
  return rows;
}

}  // namespace tactus::experiment
