#include "rt/haptics/coupling/sub_world.h"

#include <array>

#include "rt/base/hash.h"
#include "rt/base/status.h"
#include "rt/haptics/coupling/border_correction.h"
#include "rt/haptics/coupling/snapshot_bytes.h"

namespace tactus::haptics {

SubWorld::SubWorld(const SubWorldConfig& config, std::span<const physics::Body> fixed_bodies)
    : config_(config),
      coupling_(traits_of(config.scheme)),
      border_(traits_of(config.border_mode)),
      world_(config.capacities, config.shapes, config.effects),
      near_regions_(config.shapes.meshes.empty() ? 0 : kMaxNearRegions),
      near_triangles_(config.shapes.meshes.empty() ? 0 : kMaxNearTriangles),
      border_import_(config.capacities.border_contacts) {
  for (const auto& body : fixed_bodies) TACTUS_CHECK(world_.insert(body), body.id, fixed_bodies.size());
  world_.index_fixed_bodies();
  world_.border_rule.mode = config.border_mode;
  state_.last_sub_steps = config.step.sub_steps;
  state_.tank.start(border_.tank_at_start_J);
}

void SubWorld::set_members(std::span<const physics::Body> bodies) noexcept {
  for (const auto& body : bodies) {
    if (body.kind != physics::BodyKind::kDynamic) continue;
    TACTUS_CHECK(world_.insert(body), body.id, bodies.size());
    if (body.id == config_.proxy) proxy_ = body.motion;
  }
}

void SubWorld::synchronise(const WorldSnapshot& snapshot, SubWorldReport& report) noexcept {
  const bool same_world = snapshot.epoch == state_.epoch;
  const bool first = state_.has_snapshot == 0 || !same_world;
  const double before_J = state_.corrected_J;
  if (border_.has_tank && !first) note_dissipation();
  if (same_world) correct_members(snapshot);
  if (first) {
    state_.tank.start(border_.tank_at_start_J);
    state_.dissipated_J = 0.0;
  }
  if (border_.has_tank) settle_cycle(snapshot, before_J - state_.corrected_J, first);
  Leaving leaving = find_leaving(snapshot);
  fill_report(snapshot, leaving, report);
  if (!same_world) {
    forget_world(snapshot.epoch);
    leaving = {};
  }
  read_effects(snapshot.effects, false, world_);
  change_members(snapshot, leaving);
  adopt_border(snapshot);
  adopt_near_triangles(snapshot);
  if (coupling_.members_frozen) freeze_all_but_proxy();
  switch (coupling_.model) {
    case LocalModel::kMembers:
      break;
    case LocalModel::kInterpolatedProxy:
      if (first) proxy_ = snapshot.proxy;
      state_.interpolated.adopt(snapshot.proxy, first);
      break;
    case LocalModel::kProxyOnPlanes:
      if (first) planes_.start(proxy_.pose.position);
      planes_.adopt(world_.border_contacts().span());
      break;
  }
  state_.device.begin_cycle();
  state_.has_snapshot = 1;
  state_.ticks_in_cycle = 0;
  state_.cycle_impulse = {};
  state_.cycle_push_out_J = 0.0;
  if (border_.has_tank) state_.received_at_start_J = received_J() - members_J();
}

// Energy of the members: of motion, of gravity, and in the springs of their joints.
double SubWorld::members_J() const noexcept {
  return world_.kinetic_energy() + world_.potential_energy(config_.step.gravity) +
         world_.joint_springs_J(config_.step.contact_hertz);
}

// What members received in the cycle and do not have any more, was dissipated between them. A contact's spring gives
// back what it took; so less than nothing is carried on, and more than the tank's initial amount is not.
void SubWorld::note_dissipation() noexcept {
  state_.dissipated_J =
      std::min(border_.tank_at_start_J, state_.dissipated_J + received_J() - members_J() - state_.received_at_start_J);
}

// Settles the last cycle with the tank. The first snapshot's work is that of a step before there were members. A border
// that replays the step's impulses in the ticks that follow gets their work in these ticks, in equal parts.
void SubWorld::settle_cycle(const WorldSnapshot& snapshot, double taken_by_corrections_J, bool first) noexcept {
  if (border_.replays)
    state_.replayed_J = snapshot.border_work_J / config_.ratio;
  else if (!first)
    state_.tank.settle(taken_by_corrections_J + snapshot.border_work_J - state_.cycle_push_out_J);
  if (state_.dissipated_J > 0.0)
    state_.dissipated_J -= state_.tank.refill(state_.dissipated_J, border_.tank_at_start_J);
  state_.tank.keep_capacity();
  state_.tank.lend(snapshot.outside_motion_J);
}

void SubWorld::ask_reset(const Posed& world_from_proxy) noexcept {
  state_.wanted_epoch = state_.epoch + 1;
  state_.proxy_start = world_from_proxy;
}

// A displaced member does work against gravity and the springs of its joints; a displaced proxy stretches the device's
// spring, too: it does work against the spring's wrench, taken as the mean of the last cycle.
void SubWorld::correct_members(const WorldSnapshot& snapshot) noexcept {
  if (snapshot.corrections.empty()) return;
  state_.corrected_J -= world_.joint_springs_J(config_.step.contact_hertz);
  for (const MotionCorrection& correction : snapshot.corrections) {
    physics::Body* const member = world_.find(correction.id);
    if (member == nullptr) continue;
    state_.corrected_J -= kinetic_energy(*member) +
                          member->mass * member->gravity_scale * dot(config_.step.gravity, correction.displacement_m);
    member->motion = corrected(member->motion, correction);
    state_.corrected_J += kinetic_energy(*member);
    if (correction.id != config_.proxy) continue;
    const Wrenchd mean = mean_device_wrench();
    state_.corrected_J -=
        dot(mean.force, correction.displacement_m) + dot(mean.torque, small_rotation_vector(correction.rotation));
    proxy_ = member->motion;
  }
  state_.corrected_J += world_.joint_springs_J(config_.step.contact_hertz);
}

// A motion that is not finite is left out, as where the global world imposes it: this state goes into corrections.
void SubWorld::continue_from(const SubWorldReport& report) noexcept {
  for (const MemberMotion& reported : report.members) {
    physics::Body* const member = world_.find(reported.id);
    if (member == nullptr || !is_finite(reported.motion.pose) || !is_finite(reported.motion.velocity)) continue;
    member->motion = reported.motion;
    if (reported.id == config_.proxy) proxy_ = reported.motion;
  }
  read_effects(report.effects, true, world_);
  state_.tank.start(report.border_tank_J);
}

// Discards everything of the former epoch: bodies, contacts, border and effects; the next adoption restarts the tank.
void SubWorld::forget_world(std::uint32_t epoch) noexcept {
  std::array<std::uint8_t, kMaxMembers> all;
  all.fill(1);
  world_.remove(std::span<const std::uint8_t>(all).first(members()));
  world_.effects().reset();
  state_.border_work_J = border_work_J();
  world_.border_contacts().clear();
  world_.border_ghosts().clear();
  state_.epoch = epoch;
  state_.wanted_epoch = std::max(epoch, state_.wanted_epoch);
  state_.ticks_in_cycle = state_.has_snapshot = 0;
}

SubWorld::Leaving SubWorld::find_leaving(const WorldSnapshot& snapshot) const noexcept {
  Leaving leaving;
  for (std::uint32_t slot = 0; slot < members(); ++slot) {
    const BodyId id = world_.bodies()[slot].id;
    leaving.slots[slot] = !std::binary_search(snapshot.members.begin(), snapshot.members.end(), id);
    leaving.any |= leaving.slots[slot] != 0;
  }
  return leaving;
}

void SubWorld::change_members(const WorldSnapshot& snapshot, const Leaving& leaving) noexcept {
  if (leaving.any) world_.remove(std::span(leaving.slots).first(members()));
  for (const auto& joiner : snapshot.joiners) {
    if (physics::Body* member = world_.find(joiner.id)) {
      // Every snapshot contains the frozen members again.
      if (coupling_.members_frozen && joiner.id != config_.proxy) member->motion = joiner.motion;
      continue;
    }
    world_.insert(joiner);
    if (joiner.id == config_.proxy) proxy_ = joiner.motion;
  }
  adopt_impulses(snapshot);
}

// A contact that is not here yet, such as a joiner's, takes the impulses when the next step finds it.
void SubWorld::adopt_impulses(const WorldSnapshot& snapshot) noexcept {
  for (const auto& given : snapshot.warm_starts) world_.continue_contact(given, last_sub_step_s());
}

void SubWorld::adopt_border(const WorldSnapshot& snapshot) noexcept {
  state_.border_work_J = border_work_J();
  border_import_.renew(snapshot, border_, last_sub_step_s(), world_);
}

void SubWorld::adopt_near_triangles(const WorldSnapshot& snapshot) noexcept {
  if (config_.shapes.meshes.empty()) return;
  near_regions_.resize(snapshot.near_regions.size());
  std::copy(snapshot.near_regions.begin(), snapshot.near_regions.end(), near_regions_.begin());
  near_triangles_.resize(snapshot.near_triangles.size());
  std::copy(snapshot.near_triangles.begin(), snapshot.near_triangles.end(), near_triangles_.begin());
  world_.near_triangles = {near_regions_.span(), near_triangles_.span()};
}

void SubWorld::freeze_all_but_proxy() noexcept {
  for (std::uint32_t slot = 0; slot < members(); ++slot)
    world_.set_frozen(physics::SlotIndex{slot}, world_.bodies()[slot].id != config_.proxy);
}

SubWorldStep SubWorld::step(const DeviceTarget& target, std::uint32_t sub_steps,
                            const physics::CutPredicate& cut) noexcept {
  SubWorldStep result;
  const WorldLateness late = apply_lateness();
  result.status = late.status;
  result.force_scale = late.force_scale;
  switch (coupling_.model) {
    case LocalModel::kMembers:
      step_members(target, sub_steps, cut, result);
      break;
    case LocalModel::kInterpolatedProxy:
      step_interpolated(target, result);
      break;
    case LocalModel::kProxyOnPlanes:
      step_on_planes(target, result);
      break;
  }
  state_.device.note(target, config_.step.dt);
  ++state_.ticks_in_cycle;
  return result;
}

WorldLateness SubWorld::apply_lateness() noexcept {
  world_.border_rule.mode = config_.border_mode;
  if (!coupling_.global_world) return {};
  const auto late = WorldLateness::in_tick(state_.ticks_in_cycle, config_.ratio, config_.step.dt);
  border_import_.slow_down(late, world_);
  if (late.border_frozen()) world_.border_rule.mode = physics::kLateBorder;
  return late;
}

void SubWorld::step_members(const DeviceTarget& target, std::uint32_t sub_steps, const physics::CutPredicate& cut,
                            SubWorldStep& result) noexcept {
  physics::StepSettings settings = config_.step;
  settings.sub_steps = sub_steps;
  auto& spring = world_.device_spring();
  const std::optional<physics::SlotIndex> slot = world_.slot_of(config_.proxy);
  spring.enabled = slot.has_value();
  // Power that the coupling's damper takes [W].
  const auto damped_W = [&]() noexcept {
    return config_.gains.damping_Ns_per_m * norm_squared(target.velocity.linear - proxy_.velocity.linear) +
           config_.gains.damping_Nms_per_rad * norm_squared(target.velocity.angular - proxy_.velocity.angular);
  };
  Posed held_at;
  double damped_before_W = 0.0;
  if (slot) {
    held_at = world_.body(*slot).motion.pose;
    damped_before_W = damped_W();
    aim_spring(config_.gains, target, *slot, proxy_.pose, spring);
  }
  result.report = step_world(settings, cut, result);
  state_.last_sub_steps = sub_steps;

  const Wrenchd& impulse = spring.step_impulse;
  add_cycle_impulse(impulse);
  const double rate = -1.0 / settings.dt;
  const Wrenchd& felt = result.report.hand_wrench;  // of effects that act on the hand only
  if (target.engaged) result.on_device = impulse * rate + felt;
  if (spring.enabled) {
    proxy_ = world_.body(spring.slot).motion;
    if (border_.has_tank)
      state_.tank.refill(settings.dt * std::min(damped_before_W, damped_W()), border_.tank_at_start_J);
    // Work of the mean wrench over the displacement of the tick.
    const Vec3d turn = small_rotation_vector(proxy_.pose.rotation * conjugate(held_at.rotation));
    state_.proxy_work_J -=
        rate * (dot(impulse.force, proxy_.pose.position - held_at.position) + dot(impulse.torque, turn));
  }
  if (proxy_touches()) result.status |= kProxyContact;
}

// Steps the world and adds the work of the border to its energy.
physics::StepReport SubWorld::step_world(const physics::StepSettings& settings, const physics::CutPredicate& cut,
                                         SubWorldStep& result) noexcept {
  const bool has_tank = coupling_.border && traits_of(world_.border_rule.mode).has_tank;
  const double before_J = border_work_J();
  if (has_tank) {
    if (state_.ticks_in_cycle < config_.ratio) state_.tank.settle(state_.replayed_J);
    world_.border_rule.available_J = state_.tank.available_J();
  }
  world_.begin_step(settings);
  (void)physics::find_pairs_brute_force(world_.bounds(), world_.dynamic_pairs());
  const auto report = world_.finish_step(settings, cut);
  state_.border_work_J += report.border_joints_J;
  if (has_tank) {
    state_.tank.settle(before_J - border_work_J());
    state_.push_out_J += report.push_out_J;
    state_.cycle_push_out_J += report.push_out_J;
    const bool has_border = !world_.border_contacts().empty() || !world_.border_ghosts().empty();
    if (has_border && state_.tank.empty(border_.tank_at_start_J)) result.status |= kBorderSpent;
  }
  if (report.capacity_bits != 0) result.status |= kCapacityExceeded;
  if (report.cut_sweep != physics::kNeverCut) result.status |= kSolverCut;
  return report;
}

// The device feels the interpolated proxy of the global world, one cycle late.
void SubWorld::step_interpolated(const DeviceTarget& target, SubWorldStep& result) noexcept {
  proxy_ = state_.interpolated.in_tick(state_.ticks_in_cycle, config_.ratio, config_.step.dt);
  if (target.engaged) feel_proxy(target, result);
}

// The massless proxy follows the device as far as the planes allow; the wrench on it is accumulated for the report.
void SubWorld::step_on_planes(const DeviceTarget& target, SubWorldStep& result) noexcept {
  physics::Body* proxy = world_.find(config_.proxy);
  if (proxy == nullptr) return;
  proxy_.velocity = {};
  if (target.engaged) {
    const PlaneCoupling::Tick tick{.planes_hold = coupling_.planes_hold,
                                   .period_s = config_.step.dt,
                                   .in_cycle = state_.ticks_in_cycle,
                                   .ratio = config_.ratio,
                                   .lead_s = config_.gains.lead_s()};
    const HeldProxy held = planes_.follow(target, tick);
    proxy_ = {{held.position, target.pose.rotation}, {held.velocity, target.velocity.angular}};
    if (held.touches) result.status |= kProxyContact;
    feel_proxy(target, result);
  } else {
    planes_.let_go();
  }
  proxy->motion = proxy_;
}

// Applies the explicit coupling wrench of a proxy that no world simulates here.
void SubWorld::feel_proxy(const DeviceTarget& target, SubWorldStep& result) noexcept {
  const Wrenchd on_proxy = coupling_wrench(config_.gains, target, proxy_);
  add_cycle_impulse(config_.step.dt * on_proxy);
  result.on_device = -1.0 * on_proxy;
}

// Zero before the first tick of a cycle.
Wrenchd SubWorld::mean_device_wrench() const noexcept {
  if (state_.ticks_in_cycle == 0) return {};
  return state_.cycle_impulse * (1.0 / (config_.step.dt * state_.ticks_in_cycle));
}

void SubWorld::add_cycle_impulse(const Wrenchd& impulse) noexcept { state_.cycle_impulse += impulse; }

bool SubWorld::proxy_touches() const noexcept {
  for (const auto& contact : world_.contacts()) {
    if (contact.key.low() != config_.proxy && contact.key.high() != config_.proxy) continue;
    for (std::uint32_t i = 0; i < contact.count; ++i)
      if (contact.points[i].total_normal_impulse > 0) return true;
  }
  for (const auto& contact : world_.border_contacts())
    if (contact.member == config_.proxy && contact.step_normal_impulse > 0) return true;
  return false;
}

double SubWorld::border_work_J() const noexcept {
  double work = state_.border_work_J;
  for (const auto& contact : world_.border_contacts()) work += contact.work;
  return work;
}

std::uint64_t SubWorld::state_hash() const noexcept {
  Fnv1a hash;
  hash.add(world_.state_hash());
  hash.add_bytes(std::as_bytes(std::span<const physics::BodyMotion, 1>(&proxy_, 1)));
  return hash.value();
}

void SubWorld::save(ByteWriter& out) const noexcept {
  world_.save(out);
  border_import_.save(out);
  out.put(proxy_);
  out.put(state_);
  planes_.save(out);
}

bool SubWorld::restore(ByteReader& in) noexcept {
  if (!world_.restore(in) || !border_import_.restore(in, world_)) return false;
  in.get(proxy_);
  in.get(state_);
  if (!planes_.restore(in)) return false;
  world_.near_triangles = {};
  return in.ok() && state_.last_sub_steps > 0;
}

std::size_t SubWorld::save_size_bound() const noexcept {
  return world_.save_size_bound() + border_import_.save_size_bound() + sizeof(proxy_) + sizeof(state_) +
         PlaneCoupling::kMaxBytes;
}

}  // namespace tactus::haptics
