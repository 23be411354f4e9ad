#include "sim/global_world.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "rt/haptics/coupling/snapshot_bytes.h"
#include "rt/physics/body_search.h"
#include "rt/physics/macro_steps.h"
#include "sim/exchange/sub_world_config.h"
#include "sim/model/scene_effects.h"
#include "sim/model/step_settings.h"
#include "sim/model/world_capacities.h"

namespace tactus::sim {
namespace {

using haptics::SubWorldReport;
using haptics::WorldSnapshot;
using physics::Body;
using physics::BodyKind;

// Steps that the first snapshot's border is taken from. As few as find the loads: each step more is a later state.
// Measured (tests/border/README.md): 1 to 20 make nothing fall; `heavy` is off by 0.7 % at 1 and 0.3 % at 2, `tower` at
// ratio 16 by 1.4 % at 2 and 10 % at 5.
constexpr unsigned kPredictionSteps = 2;
// Fraction of the last cycle's change in device wrench that is extrapolated into the next cycle. 1 is exact for a ramp;
// a hand trembles. On the pushed row of `experiment energy-loss` (2026-11-23) less than 0.9 gains more energy at ratio
// 16, and more than 0.9 loses more at ratio 8.
constexpr double kWrenchExtrapolation = 0.9;
// With more bodies awake, a step is taken in one macro step.
constexpr std::size_t kMaxBodiesInMacroSteps = 500;

unsigned haptic_sub_steps_of(const Scene& scene, const GlobalOptions& options) noexcept {
  return options.haptic_sub_steps != 0 ? options.haptic_sub_steps : scene.solver.sub_steps;
}

GlobalStep global_step_for(const Scene& scene, const GlobalOptions& options) noexcept {
  const bool ghosts = traits_of(options.coupling).border && traits_of(options.border_mode).ghosts;
  return global_step(scene, options.reach.ratio, haptic_sub_steps_of(scene, options), ghosts);
}

SleepRule sleep_rule_for(const Scene& scene, const GlobalOptions& options, double step_s) noexcept {
  const SleepingChoice& choice = scene.sleeping;
  return {scene.effects.sleeping && !options.extraction.all_members, choice.max_speed_m_per_s,
          static_cast<std::uint32_t>(std::max(1.0, std::ceil(choice.after_s / step_s)))};
}

std::uint32_t touches_for(const Scene& scene) noexcept {
  return capacities_for(scene).contacts + static_cast<std::uint32_t>(scene.effect_data.joints.size());
}

// A world with all moving and fixed bodies of the scene.
physics::World world_of(const Scene& scene, const GlobalOptions& options) {
  physics::World world(capacities_for(scene), scene.shapes(), global_effect_setups(scene), options.precision);
  for (const auto& body : scene.bodies) TACTUS_CHECK(world.insert(body), body.id, scene.bodies.size());
  world.index_fixed_bodies();
  return world;
}

Vec3d clamp_norm(const Vec3d& v, double length) noexcept {
  const double own = norm(v);
  return own > length ? v * (length / own) : v;
}

double energy_of(const Body& body, const Vec3d& gravity) noexcept {
  return kinetic_energy(body) - body.mass * body.gravity_scale * dot(gravity, body.motion.pose.position);
}

// Moves the outside bodies' side of a border from the poses of `then` to the present motions of `now`; loads stay. A
// body that is not among both is asleep, and stays where it is.
void bring_back(std::span<const Body> then, std::span<const Body> now, WorldSnapshot& border) noexcept {
  const auto both = [&](BodyId id, auto&& move) noexcept {
    const std::uint32_t before = physics::find_slot(then, id), at = physics::find_slot(now, id);
    if (before != physics::kNoSlot && at != physics::kNoSlot) move(then[before].motion.pose, now[at].motion);
  };
  for (haptics::BorderPoint& point : border.border)
    both(point.outside, [&](const Posed& from, const physics::BodyMotion& to) noexcept {
      const Vec3d to_centre = point.outside_round_m * point.normal;
      const Vec3d anchor = rotate_inverse(from.rotation, point.outside_point - to_centre - from.position);
      point.outside_point = to.pose * anchor + to_centre;
      point.outside_velocity = to.velocity.linear + cross(to.velocity.angular, point.outside_point - to.pose.position);
    });
  for (haptics::OutsideBody& outside : border.outside)
    both(outside.id, [&](const Posed&, const physics::BodyMotion& to) noexcept {
      outside.centre = to.pose.position;
      outside.velocity = to.velocity;
    });
}

}  // namespace

GlobalWorld::GlobalWorld(const Scene& scene, const GlobalOptions& options)
    : scene_(&scene),
      options_(options),
      coupling_(traits_of(options.coupling)),
      border_(traits_of(options.border_mode)),
      global_step_(global_step_for(scene, options)),
      settings_(step_settings(scene, options.reach.ratio * options.reach.tick_period_s, global_step_.sub_steps)),
      bounds_settings_(settings_),
      world_(world_of(scene, options)),
      islands_(sleep_rule_for(scene, options, settings_.dt), world_, capacities_for(scene).contacts),
      pair_cache_(capacities_for(scene).bodies, capacities_for(scene).pairs),
      graph_(capacities_for(scene).bodies, touches_for(scene)),
      approach_(capacities_for(scene).bodies),
      border_exchange_(capacities_for(scene).bodies, capacities_for(scene).contacts,
                       static_cast<std::uint32_t>(scene.effect_data.joints.size()),
                       physics::Softness<double>::added_inertia(settings_.contact_hertz,
                                                                settings_.contact_damping_ratio, settings_.dt)),
      bounds_(capacities_for(scene).bodies),
      free_(capacities_for(scene).bodies),
      kept_awake_(capacities_for(scene).bodies) {
  touches_.reserve(touches_for(scene));
  member_slots_.reserve(capacities_for(scene).bodies);
  velocity_before_.reserve(capacities_for(scene).bodies);
  add_device(scene, {.proxy = scene.proxy,
                     .gains = options.gains,
                     .max_speed_m_per_s = options.reach.max_speed_m_per_s,
                     .max_angular_speed_rad_per_s = options.reach.max_angular_speed_rad_per_s});
  for (const FurtherDevice& device : options.more_devices) add_device(scene, device);
  for (Device& device : devices_) device.component.reserve(islands_.bodies().size());
  if (devices_.size() > 1) {
    touched_bodies_.reserve(islands_.bodies().size());
    for (Device& device : devices_) device.apart = BodyVector<std::uint32_t>(islands_.bodies().size(), kLongApart);
  }
  regions_.resize(devices_.size());
  bounds_settings_.sub_steps = global_step_.far_sub_steps;
  statistics_.bodies = static_cast<std::uint32_t>(islands_.bodies().size());
  statistics_.fixed_bodies = static_cast<std::uint32_t>(world_.fixed_bodies().size());
  statistics_.energy.complete = coupling_.border && devices_.size() == 1 && energy_balance_is_complete(scene);
  thinnest_m_ = physics::thinnest(scene.bodies);
  if (scene.sleeping.from_start) sleep_from_start();
  asleep_J_ = islands_.potential_energy(settings_.gravity);
  asleep_of_ = islands_.fell_asleep() + islands_.woke_up();
  statistics_.awake = statistics_.most_awake = static_cast<std::uint32_t>(islands_.awake().size());
  statistics_.asleep = islands_.asleep();
}

void GlobalWorld::add_device(const Scene& scene, const FurtherDevice& added) {
  const std::optional<BodyIndex> found = islands_.index_of(added.proxy);
  TACTUS_CHECK(found.has_value(), added.proxy, scene.bodies.size());
  const BodyIndex proxy = *found;
  ReachSettings reach = options_.reach;
  reach.max_speed_m_per_s = added.max_speed_m_per_s;
  reach.max_angular_speed_rad_per_s = added.max_angular_speed_rad_per_s;
  devices_.push_back(
      {.id = added.proxy,
       .proxy = proxy,
       .extraction = Extraction(options_.extraction, reach, islands_.bodies(), proxy, touches_for(scene)),
       .gains = added.gains,
       .reach = reach,
       .reported_proxy = islands_.bodies()[proxy].motion.pose});
  if (!coupling_.border || !border_.ghosts) return;
  const SubWorldChoice choice{.coupling = options_.coupling,
                              .border = options_.border_mode,
                              .proxy = added.proxy,
                              .ratio = reach.ratio,
                              .tick_period_s = reach.tick_period_s,
                              .sub_steps = haptic_sub_steps_of(scene, options_),
                              .members = options_.extraction.cap,
                              .gains = added.gains};
  predictions_.push_back(std::make_unique<SubWorldPrediction>(sub_world_config(scene, choice), fixed_bodies_of(scene)));
}

physics::SlotIndex GlobalWorld::slot_of(const Device& device) const noexcept {
  const std::optional<physics::SlotIndex> slot = world_.slot_of(device.id);
  TACTUS_CHECK(slot.has_value(), device.id, world_.bodies().size());  // a proxy never sleeps
  return *slot;
}

std::span<const std::uint8_t> GlobalWorld::member_slots(const Device& device) noexcept {
  member_slots_.clear();
  for (const BodyIndex body : islands_.awake()) member_slots_.push_back(device.extraction.is_member(body) ? 1 : 0);
  return member_slots_;
}

// By slot: 1 for members of any device's sub-world.
std::span<const std::uint8_t> GlobalWorld::slots_of_all_members() noexcept {
  member_slots_.clear();
  for (const BodyIndex body : islands_.awake())
    member_slots_.push_back(std::any_of(devices_.begin(), devices_.end(),
                                        [body](const Device& device) { return device.extraction.is_member(body); }));
  return member_slots_;
}

void GlobalWorld::share_work(WorkerPool& pool) {
  pool_ = &pool;
  world_.share_work(pool.executor());
  pair_cache_.share_work(pool.executor(), pool.threads());
}

void GlobalWorld::set_state(std::span<const Body> bodies, std::span<const physics::WarmStart> contacts) noexcept {
  for (const auto& body : bodies)
    if (Body* awake = world_.find(body.id)) awake->motion = body.motion;
  for (const auto& contact : contacts) world_.add_warm_start(contact);
  islands_.follow(world_);
  for (Device& device : devices_) device.reported_proxy = world_.body(slot_of(device)).motion.pose;
}

void GlobalWorld::first_snapshot(WorldSnapshot& first, std::uint32_t device) noexcept {
  fill_first(device, 0, haptics::kMaxMembers, first);
}

void GlobalWorld::fill_first(std::uint32_t device, std::uint64_t cycle, std::uint32_t budget,
                             WorldSnapshot& next) noexcept {
  find_touches_at_rest();
  choose_members(device, cycle, budget, next);
  if (coupling_.border) predict_border(device, next);
  if (predicts()) predictions_[device]->adopt(next);
}

// Resets the world to the scene's start; the statistics continue.
void GlobalWorld::reset(std::span<const SubWorldReport* const> reports) {
  GlobalStatistics statistics = statistics_;
  WorkerPool* const pool = pool_;
  *this = GlobalWorld(*scene_, options_);
  statistics.energy.reset();
  statistics.awake = statistics_.awake;
  statistics.asleep = statistics_.asleep;
  ++statistics.resets;
  statistics_ = statistics;
  if (pool != nullptr) share_work(*pool);
  for (std::size_t d = 0; d < devices_.size(); ++d) {
    Device& device = devices_[d];
    world_.body(slot_of(device)).motion = {reports[d]->proxy_start, {}};
    islands_.follow(world_);
    device.reported_proxy = reports[d]->proxy_start;
    wake_near(device);
  }
}

// Without impulses in the first snapshot, members that rest on outside bodies or hang on them would fall in the first
// cycle. So the world takes a few steps, the loads at their border and the joints' efforts are kept, and the state is
// restored. Ghosts begin where their bodies are, and move as these do.
void GlobalWorld::predict_border(std::uint32_t device, WorldSnapshot& first) noexcept {
  const std::vector<std::byte> world = saved_world();
  const IslandManager islands = islands_;
  const BorderExchange exchange = border_exchange_;
  const GlobalStatistics statistics = statistics_;
  const double time_s = time_s_;
  const bool stepped = stepped_;
  for (unsigned step = 0; step < kPredictionSteps; ++step) advance();
  fill_border(devices_[device], first);
  devices_[device].has_border = first.has_border();
  const std::span<const Body> bodies = std::as_const(world_).bodies();
  const std::vector<Body> then(bodies.begin(), bodies.end());
  std::vector<physics::JointState> states;
  if (const auto* joints = world_.effects().find<physics::Joints>())
    states.assign(joints->states().begin(), joints->states().end());
  restore_world(world);
  if (border_.ghosts) bring_back(then, std::as_const(world_).bodies(), first);
  if (auto* joints = world_.effects().find<physics::Joints>()) {
    joints->start_from(states);
    (void)haptics::write_effects(world_, member_slots(devices_[device]), first.effects);  // fits, as before
    restore_world(world);
  }
  islands_ = islands;
  border_exchange_ = exchange;
  statistics_ = statistics;
  time_s_ = time_s;
  stepped_ = stepped;
}

void GlobalWorld::step(const SubWorldReport& report, WorldSnapshot& next) noexcept {
  const SubWorldReport* const from = &report;
  WorldSnapshot* const to = &next;
  step({&from, 1}, {&to, 1});
}

void GlobalWorld::step(std::span<const SubWorldReport* const> reports, std::span<WorldSnapshot* const> next) noexcept {
  TACTUS_CHECK(reports.size() == devices_.size() && next.size() == devices_.size(), reports.size(), devices_.size());
  const bool resets = std::all_of(reports.begin(), reports.end(), [this](const SubWorldReport* report) noexcept {
    return report != nullptr && report->wanted_epoch > epoch() && is_finite(report->proxy_start);
  });
  if (resets) {
    reset(reports);
    for (std::uint32_t d = 0; d < devices_.size(); ++d)
      fill_first(d, reports[d]->cycle + 1, reports[d]->member_budget, *next[d]);
    return;
  }
  for (std::uint32_t d = 0; d < devices_.size(); ++d) {
    if (reports[d] == nullptr)
      leave_out(devices_[d]);
    else if (reports[d]->epoch == epoch())
      impose(d, *reports[d]);  // else it was written before a reset
  }
  advance();
  for (std::uint32_t d = 0; d < devices_.size(); ++d)
    if (reports[d] != nullptr) fill_snapshot(d, reports[d]->cycle + 1, reports[d]->member_budget, *next[d]);
}

void GlobalWorld::impose(std::uint32_t device_index, const SubWorldReport& report) noexcept {
  Device& device = devices_[device_index];
  if (!coupling_.imposes_motion) {
    take_hand(device, report);
    device.reported_proxy = world_.body(slot_of(device)).motion.pose;
    wake_near(device);
    return;
  }
  wake_for(report);
  impose_motion(device, report);
  update_energy_balance(report);
  wake_near(device);
  if (coupling_.border) {
    haptics::read_effects(report.effects, true, world_);
    for (const auto& warm_start : report.warm_starts) world_.add_warm_start(warm_start);
    count(return_impulses(report.border.span(), slots_of_all_members(), border_.returns, world_));
  }
  if (coupling_.device_load == haptics::DeviceLoad::kSpring) {
    take_hand(device, report);
    if (predicts()) {
      SubWorldPrediction& prediction = *predictions_[device_index];
      count(return_impulses(prediction.not_predicted(report), world_));
      prediction.run(report, device.hand);
    }
    return;
  }
  // Extrapolates the mean device wrench of the last cycle. The change is limited to the wrench's magnitude, so that a
  // hand that lets go does not pull. The next report corrects the error.
  const Wrenchd& mean = report.mean_device_wrench;
  if (!is_finite(mean)) return;
  const Wrenchd& before = device.last_device_wrench == Wrenchd{} ? mean : device.last_device_wrench;
  device.device_wrench = {
      mean.force + clamp_norm(kWrenchExtrapolation * (mean.force - before.force), norm(mean.force)),
      mean.torque + clamp_norm(kWrenchExtrapolation * (mean.torque - before.torque), norm(mean.torque))};
  device.last_device_wrench = mean;
}

PredictionWork GlobalWorld::prediction_work() const noexcept {
  PredictionWork work;
  for (const auto& prediction : predictions_) {
    const haptics::SubWorld& sub_world = prediction->sub_world();
    const physics::StepReport& tick = prediction->last_tick();
    work.sub_steps = sub_world.config().step.sub_steps;
    work.members += sub_world.members();
    work.border += sub_world.border_contacts();
    work.pairs += tick.pairs;
    work.contacts += tick.contacts;
    work.points += tick.points;
    work.comparisons += tick.comparisons;
  }
  return work;
}

void GlobalWorld::count(const ImpulseReturn& back) noexcept {
  statistics_.returned_impulse_Ns += back.magnitude_Ns;
  statistics_.returned_energy_J += back.energy_J;
  statistics_.returned_skipped += back.skipped;
}

// Copies pose and velocity of the members, bit by bit; with the static coupling only the proxy's, since the other
// members were frozen.
void GlobalWorld::impose_motion(Device& device, const SubWorldReport& report) noexcept {
  double before = 0, after = 0;
  for (const auto& member : report.members) {
    Body* const body = world_.find(member.id);
    if (body == nullptr) continue;
    if (coupling_.members_frozen && member.id != device.id) continue;
    if (!is_finite(member.motion.pose) || !is_finite(member.motion.velocity)) {
      ++statistics_.rejected_states;
      continue;
    }
    before += energy_of(*body, settings_.gravity);
    body->motion = member.motion;
    after += energy_of(*body, settings_.gravity);
  }
  statistics_.imposed_energy_J += after - before;
  device.reported_proxy = world_.body(slot_of(device)).motion.pose;
}

physics::StepReport GlobalWorld::take_macro_step(std::uint32_t macro_step, std::uint32_t macro_steps) noexcept {
  const auto settings = physics::settings_of_macro_step(settings_, macro_steps);
  hold_proxy(macro_step * settings.dt, settings.dt);
  const auto bounds_settings = physics::settings_of_macro_step(bounds_settings_, macro_steps);
  for (const Device& device : devices_)
    if (device.device_wrench != Wrenchd{}) world_.apply_wrench(slot_of(device), device.device_wrench);
  world_.begin_step(bounds_settings);
  while (islands_.wake_touched(world_)) world_.begin_step(bounds_settings);  // a woken body may wake others
  if (!pair_cache_.find(world_.bounds(), world_.dynamic_pairs())) statistics_.capacity_bits |= physics::kPairsFull;
  physics::CoarseRegion far = coarse_region();
  far.sub_steps = std::max(1u, far.sub_steps / macro_steps);
  macro_step_s_ = settings.dt;
  note_member_velocities();
  const auto report = world_.finish_step(settings, {}, far);
  add_border_work();
  return report;
}

// Copies only the members' velocities: most of thousands of bodies are not members.
void GlobalWorld::note_member_velocities() noexcept {
  velocity_before_.resize(world_.bodies().size());
  for (const Device& device : devices_)
    for (const BodyIndex body : device.extraction.members())
      if (const auto slot = world_.slot_of(islands_.bodies()[body].id))
        velocity_before_[number_of(*slot)] = world_.body(*slot).motion.velocity;
}

void GlobalWorld::add_border_work() noexcept {
  if (!coupling_.border || !border_.has_tank) return;
  for (std::uint32_t d = 0; d < devices_.size(); ++d) {
    Device& device = devices_[d];
    const auto members = member_slots(device);
    double work_J = border_work_J(world_, velocity_before_, members, macro_step_s_);
    if (device.has_border && border_.ghosts)  // where the sub-world has ghosts and counts it, too
      work_J += push_out_J(world_, velocity_before_, members, macro_step_s_, settings_.gravity,
                           std::as_const(world_).device_spring(d));
    device.border_work_J += work_J;
    statistics_.border_work_J += work_J;
  }
}

// Number of macro steps of the next step. One if a border exchanges the impulses of a whole step (ghosts use those of
// the last macro step), and one for a large world, since every further macro step costs as much again. The speed of
// members counts only with ghosts: else their motion in the sub-world replaces that of the step.
std::uint32_t GlobalWorld::macro_steps_of_step() noexcept {
  if (global_step_.tick_by_tick) return options_.reach.ratio;
  if (islands_.awake().size() > kMaxBodiesInMacroSteps) return 1;
  for (const Device& device : devices_)
    if (device.has_border && !border_.ghosts) return 1;
  member_slots_.clear();
  if (devices_.size() == 1 && coupling_.imposes_motion && !predicts())
    for (const BodyIndex body : islands_.awake())
      member_slots_.push_back(devices_[0].extraction.is_member(body) ? 1 : 0);
  return std::gcd(physics::macro_steps_of(world_, bounds_settings_, member_slots_), settings_.sub_steps);
}

// Updates the deepest relative overlap. An overlap that is no new maximum relative to the thinnest body cannot be one
// relative to its own bodies, and the search is skipped.
void GlobalWorld::look_at_overlaps(double deepest_m) noexcept {
  if (!(deepest_m > statistics_.overlap.share * thinnest_m_)) return;
  const physics::Overlap deepest = physics::deepest_overlap(world_);
  if (deepest.share > statistics_.overlap.share) statistics_.overlap = deepest;
}

// Adds the energy at t_n to the balance, with the members' state as imposed. Call before impulses are returned:
// contacts have not yet reacted to those.
void GlobalWorld::update_energy_balance(const SubWorldReport& report) noexcept {
  if (!statistics_.energy.due()) return;
  // Sleeping bodies do not move: their sum is recomputed only when their set changes.
  const std::uint64_t changes = islands_.fell_asleep() + islands_.woke_up();
  if (changes != asleep_of_) asleep_J_ = islands_.potential_energy(settings_.gravity);
  asleep_of_ = changes;
  statistics_.energy.add(kinetic_energy_J(), world_.potential_energy(settings_.gravity) + asleep_J_, springs_J(),
                         report.proxy_work_J);
}

void GlobalWorld::advance() noexcept {
  const std::uint32_t macro_steps = macro_steps_of_step();
  physics::StepReport report;
  std::uint32_t comparisons = 0;
  for (Device& device : devices_) device.border_work_J = 0;
  border_exchange_.begin_step();
  for (std::uint32_t macro_step = 0; macro_step < macro_steps; ++macro_step) {
    const std::uint32_t bits = report.capacity_bits;
    const double deepest_m = report.deepest_m;
    report = take_macro_step(macro_step, macro_steps);
    look_at_overlaps(report.deepest_m);
    comparisons += report.comparisons;
    report.capacity_bits |= bits;
    report.deepest_m = std::max(report.deepest_m, deepest_m);
  }
  for (Device& device : devices_) device.device_wrench = {};
  const auto awake = static_cast<std::uint32_t>(islands_.awake().size());
  time_s_ += settings_.dt;
  stepped_ = true;
  islands_.follow(world_);
  sleep();
  find_touches();

  auto& s = statistics_;
  ++s.steps;
  s.awake = static_cast<std::uint32_t>(islands_.awake().size());
  s.asleep = islands_.asleep();
  s.most_awake = std::max(s.most_awake, awake);
  s.fell_asleep = islands_.fell_asleep();
  s.woke_up = islands_.woke_up();
  s.stopped_energy_J = islands_.stopped_energy_J();
  s.pairs = report.pairs;
  s.contacts = report.contacts;
  s.points = report.points;
  s.comparisons = comparisons;
  s.prediction = prediction_work();
  s.most_pairs = std::max(s.most_pairs, report.pairs);
  s.most_contacts = std::max(s.most_contacts, report.contacts);
  s.capacity_bits |= report.capacity_bits;
  s.dropped_entries += report.dropped;
  s.deepest_m = std::max(s.deepest_m, report.deepest_m);
}

}  // namespace tactus::sim
