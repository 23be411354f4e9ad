#include "rt/haptics/sub_world.h"

#include <array>

#include "rt/base/hash.h"
#include "rt/base/status.h"
#include "rt/haptics/snapshot_bytes.h"

namespace tactus::haptics {
namespace {

// Past this the global world counts as lost and the force fades out; it comes back by itself.
constexpr double kWorldLostAfter_s = 0.1;
constexpr double kWorldFadeTicks = 10;
// Past ratio x this the border bodies count as standing still.
constexpr std::uint32_t kFreezeAfterCycles = 4;
// How far a border contact's predecessor is looked for; one that moved further starts cold, which costs a sweep.
constexpr std::uint32_t kSearchWindow = 32;
// The tank holds no more, so that what was taken out long ago is not put in at once.
constexpr double kMostInTank_J = 0.1;

bool contains(std::span<const BodyId> sorted, BodyId id) noexcept {
  return std::binary_search(sorted.begin(), sorted.end(), id);
}

// What moves them, too.
void slow_down(std::span<physics::BorderGhost> ghosts, double share) noexcept {
  for (auto& ghost : ghosts) {
    ghost.velocity = {share * ghost.velocity.linear, share * ghost.velocity.angular};
    ghost.drive = {share * ghost.drive.linear, share * ghost.drive.angular};
  }
}

}  // namespace

SubWorld::SubWorld(const SubWorldConfig& config, std::span<const physics::Body> fixed_bodies)
    : config_(config),
      world_(config.capacities, config.hulls, config.meshes, config.effects),
      outside_velocity_(config.capacities.border_contacts),
      replaced_(config.capacities.border_contacts),
      near_regions_(config.meshes.empty() ? 0 : kMaxNearRegions),
      near_triangles_(config.meshes.empty() ? 0 : kMaxNearTriangles) {
  for (const auto& body : fixed_bodies) TACTUS_CHECK(world_.insert(body), body.id, fixed_bodies.size());
  world_.index_fixed_bodies();
  state_.last_sub_steps = config.step.sub_steps;
  world_.border_mode = config.border_mode;
  auto& spring = world_.device_spring();
  spring.stiffness_N_per_m = config.stiffness_N_per_m;
  spring.damping_Ns_per_m = config.damping_Ns_per_m;
  spring.stiffness_Nm_per_rad = config.stiffness_Nm_per_rad;
  spring.damping_Nms_per_rad = config.damping_Nms_per_rad;
}

void SubWorld::set_members(std::span<const physics::Body> bodies) noexcept {
  for (const auto& body : bodies) {
    if (body.kind != physics::BodyKind::kDynamic) continue;
    TACTUS_CHECK(world_.insert(body), body.id, bodies.size());
    if (body.id == config_.proxy) proxy_ = body.motion;
  }
}

void SubWorld::synchronise(const WorldSnapshot& snapshot, SubWorldReport& report) noexcept {
  fill_report(snapshot, report);
  if (snapshot.epoch != state_.epoch) forget_world(snapshot.epoch);
  if (state_.has_snapshot == 0) {
    // Ghosts have something in advance; a filter that shall not let energy be gained has not.
    state_.tank_J = config_.border_mode == physics::BorderMode::kFiltered ? 0.0 : kTankAtStart_J;
    state_.owed_J = state_.credit_J = 0;
  }
  read_effects(snapshot.effects, false, world_);
  change_members(snapshot);
  adopt_buffer(snapshot, report.mean_device_wrench.force);
  renew_border(snapshot);
  take_near_triangles(snapshot.near_regions.span(), snapshot.near_triangles.span());
  if (config_.scheme == CouplingScheme::kStatic) freeze_all_but_proxy();
  if (config_.scheme == CouplingScheme::kInterpolation && state_.has_snapshot == 0) proxy_ = snapshot.proxy;
  state_.interpolation.adopt(snapshot.proxy, state_.has_snapshot == 0);
  if (feels_planes(config_.scheme)) {
    if (state_.has_snapshot == 0) planes_.start(proxy_.pose.position);
    planes_.adopt(world_.border_contacts().span());
  }
  state_.has_snapshot = 1;
  state_.ticks_in_cycle = 0;
  state_.cycle_impulse = {};
}

// With the proxy the end of the coupling's spring goes where buffer bodies carry it: against its force, mean of the
// last cycle, that is energy of the border.
void SubWorld::adopt_buffer(const WorldSnapshot& snapshot, const Vec3d& coupling_force_N) noexcept {
  const BorderBuffer::Adopted adopted = buffer_.adopt(snapshot, config_.proxy, world_);
  state_.buffer_gain_J += adopted.gained_J - dot(coupling_force_N, adopted.proxy_carried);
  const std::int32_t slot = world_.slot_of(config_.proxy);
  if (slot < 0 || adopted.proxy_carried == Vec3d{}) return;
  auto& motion = world_.bodies()[static_cast<std::uint32_t>(slot)].motion;
  motion.pose.position += adopted.proxy_carried;
  proxy_ = motion;
}

void SubWorld::fill_report(const WorldSnapshot& snapshot, SubWorldReport& report) const noexcept {
  report.cycle = snapshot.cycle;
  report.ticks = state_.ticks_in_cycle;
  report.epoch = state_.epoch;
  report.wanted_epoch = state_.wanted_epoch;
  report.proxy_work_J = state_.proxy_work_J;
  report.proxy_start = state_.proxy_start;
  report.members.clear();
  report.border.clear();
  report.warm_starts.clear();
  report.effects.clear();
  report.mean_device_wrench = {};
  report.device = state_.interpolation.latest();
  if (config_.scheme == CouplingScheme::kInterpolation) {
    report.device = state_.interpolation.report(state_.ticks_in_cycle, config_.step.dt);
    return;
  }
  if (state_.ticks_in_cycle > 0) {
    const double rate = 1.0 / (config_.step.dt * state_.ticks_in_cycle);
    report.mean_device_wrench = {state_.cycle_impulse.force * rate, state_.cycle_impulse.torque * rate};
  }
  for (const auto& body : world_.bodies()) {
    if (config_.scheme == CouplingScheme::kStatic && body.id != config_.proxy) continue;
    // At most kMaxMembers are ever members of a sub-world that exchanges: joins are bounded by the same capacity.
    if (!report.members.try_push({body.id, buffer_.holds(body.id) ? 1u : 0u, body.motion})) break;
  }
  report_leavers(snapshot, report);
  report_border(report);
  (void)write_effects(world_, {}, report.effects);
}

// What the contacts of those that leave carry, so that the global world goes on from there.
void SubWorld::report_leavers(const WorldSnapshot& snapshot, SubWorldReport& report) const noexcept {
  const double sub_step_s = config_.step.dt / state_.last_sub_steps;
  for (const auto& contact : world_.contacts()) {
    const bool low_stays = contains(snapshot.members.span(), contact.key.low());
    const bool high_stays = contains(snapshot.members.span(), contact.key.high());
    const bool one_leaves = contact.b_fixed ? !contains(snapshot.members.span(), world_.bodies()[contact.slot_a].id)
                                            : !(low_stays && high_stays);
    if (one_leaves && !report.warm_starts.try_push(physics::World::warm_start_of(contact, sub_step_s))) return;
  }
}

void SubWorld::report_border(SubWorldReport& report) const noexcept {
  for (const auto& contact : world_.border_contacts()) {
    const std::int32_t slot = world_.slot_of(contact.member);
    if (slot < 0) continue;
    const Posed& pose = world_.bodies()[static_cast<std::uint32_t>(slot)].motion.pose;
    const BorderReturn entry{contact.member,
                             contact.outside,
                             contact.feature,
                             0,
                             pose * contact.member_anchor,
                             contact.normal,
                             contact.total_tangent_impulse,
                             contact.total_normal_impulse};
    if (!report.border.try_push(entry)) return;
  }
}

void SubWorld::ask_reset(const Posed& world_from_proxy) noexcept {
  state_.wanted_epoch = state_.epoch + 1;
  state_.proxy_start = world_from_proxy;
}

// Nothing of another epoch goes on: no body, no contact, no border, no effect, no energy in the tank.
void SubWorld::forget_world(std::uint32_t epoch) noexcept {
  std::array<std::uint8_t, kMaxMembers> all;
  all.fill(1);
  world_.remove(std::span<const std::uint8_t>(all).first(members()));
  world_.effects().begin_anew();
  state_.border_work_J = border_work_J();
  world_.border_contacts().clear();
  world_.border_ghosts().clear();
  buffer_.clear();
  state_.epoch = epoch;
  state_.wanted_epoch = std::max(epoch, state_.wanted_epoch);
  state_.ticks_in_cycle = state_.has_snapshot = 0;
}

void SubWorld::change_members(const WorldSnapshot& snapshot) noexcept {
  for (std::uint32_t slot = members(); slot-- > 0;) {
    const BodyId id = world_.bodies()[slot].id;
    if (!contains(snapshot.members.span(), id)) world_.remove(id);
  }
  for (const auto& joiner : snapshot.joiners) {
    const std::int32_t slot = world_.slot_of(joiner.id);
    if (slot >= 0) {
      // Only the static coupling sends bodies that are here already: its frozen members are refreshed.
      if (config_.scheme == CouplingScheme::kStatic && joiner.id != config_.proxy)
        world_.bodies()[static_cast<std::uint32_t>(slot)].motion = joiner.motion;
      continue;
    }
    world_.insert(joiner);
    if (joiner.id == config_.proxy) proxy_ = joiner.motion;
  }
  for (const auto& warm_start : snapshot.warm_starts) world_.add_warm_start(warm_start);
}

// Border contacts are new at every synchronisation (the friction point too); one that was there before keeps the
// impulses that start the solver.
void SubWorld::renew_border(const WorldSnapshot& snapshot) noexcept {
  auto& contacts = world_.border_contacts();
  for (const auto& contact : contacts) state_.border_work_J += contact.work;
  replaced_.swap(contacts);
  contacts.clear();
  if (config_.border_mode == physics::BorderMode::kGhost) renew_ghosts(snapshot);
  outside_velocity_.clear();
  std::uint32_t hint = 0;
  for (const BorderPoint& point : snapshot.border) {
    const std::int32_t slot = world_.slot_of(point.member);
    if (slot < 0) continue;
    physics::BorderContact contact;
    contact.member = point.member, contact.outside = point.outside, contact.feature = point.feature;
    contact.normal = point.normal;
    contact.member_anchor = point.member_anchor;
    contact.impulse_rate = point.impulse_rate_N;
    contact.friction = point.friction;
    contact.outside_velocity = point.outside_velocity;
    contact.outside_inverse_mass = point.outside_inverse_mass;
    contact.line_point = world_.bodies()[static_cast<std::uint32_t>(slot)].motion.pose * point.member_anchor;
    contact.gap = point.separation_m + dot(point.normal, contact.line_point - point.outside_point);
    // Both lists are in the global world's order, so the old one is near where the last one was found.
    for (std::uint32_t i = 0; i < std::min(kSearchWindow, replaced_.size()); ++i) {
      const std::uint32_t at = (hint + i) % replaced_.size();
      const auto& old = replaced_[at];
      if (old.member != contact.member || old.outside != contact.outside || old.feature != contact.feature) continue;
      contact.normal_impulse = old.normal_impulse;
      contact.tangent_impulse[0] = old.tangent_impulse[0];
      contact.tangent_impulse[1] = old.tangent_impulse[1];
      hint = at + 1;
      break;
    }
    if (config_.border_mode == physics::BorderMode::kGhost)
      contact.ghost = physics::find_ghost(world_.border_ghosts().span(), point.outside);
    // The world counts what does not fit, and the next step reports it.
    if (world_.add_border_contact(contact)) (void)outside_velocity_.try_push(point.outside_velocity);
  }
  border_count_ = contacts.size();
  state_.credit_J = snapshot.border_work_J / config_.ratio;
}

// A ghost for each outside body, moving as the global step left it.
void SubWorld::renew_ghosts(const WorldSnapshot& snapshot) noexcept {
  auto& ghosts = world_.border_ghosts();
  ghosts.clear();
  for (const OutsideBody& body : snapshot.outside) {
    physics::BorderGhost ghost;
    ghost.outside = body.id;
    ghost.centre = body.centre;
    ghost.velocity = body.velocity;
    ghost.admittance = body.admittance;
    ghost.drive = body.drive;
    if (!ghosts.try_push(ghost)) return;
  }
}

// What the outside bodies did to members in the global step, ghosts may do here as well, tick by tick; a late world has
// told of no more than r ticks.
double SubWorld::tick_credit_J() const noexcept {
  return state_.ticks_in_cycle < config_.ratio ? state_.credit_J : 0.0;
}

void SubWorld::put_in_tank(double energy_J) noexcept {
  const double balance = state_.tank_J - state_.owed_J + energy_J;
  state_.tank_J = std::clamp(balance, 0.0, kMostInTank_J);
  state_.owed_J = std::max(0.0, -balance);
}

void SubWorld::take_near_triangles(std::span<const physics::NearRegion> regions,
                                   std::span<const std::uint32_t> triangles) noexcept {
  if (config_.meshes.empty()) return;
  near_regions_.resize(static_cast<std::uint32_t>(regions.size()));
  std::copy(regions.begin(), regions.end(), near_regions_.begin());
  near_triangles_.resize(static_cast<std::uint32_t>(triangles.size()));
  std::copy(triangles.begin(), triangles.end(), near_triangles_.begin());
  world_.near_triangles = {near_regions_.span(), near_triangles_.span()};
}

void SubWorld::freeze_all_but_proxy() noexcept {
  for (std::uint32_t slot = 0; slot < members(); ++slot)
    world_.set_frozen(slot, world_.bodies()[slot].id != config_.proxy);
}

SubWorldStep SubWorld::step(const DeviceTarget& target, std::uint32_t sub_steps,
                            const physics::CutPredicate& cut) noexcept {
  SubWorldStep result;
  apply_lateness(result);
  if (config_.scheme == CouplingScheme::kInterpolation)
    step_interpolated(target, result);
  else if (feels_planes(config_.scheme))
    step_on_planes(target, result);
  else
    step_world(target, sub_steps, cut, result);
  state_.interpolation.note(target, config_.step.dt);
  ++state_.ticks_in_cycle;
  return result;
}

// The rule for a late world: outside velocities fade over r ticks; past 4 r the border stands still; past 100 ms the
// force fades out. All of it ends with the next snapshot.
void SubWorld::apply_lateness(SubWorldStep& result) noexcept {
  world_.border_mode = config_.border_mode;
  if (!exchanges()) return;
  const std::uint32_t late = state_.ticks_in_cycle >= config_.ratio ? state_.ticks_in_cycle - config_.ratio + 1 : 0;
  const double fade = late == 0 ? 1.0 : std::max(0.0, 1.0 - static_cast<double>(late) / config_.ratio);
  auto& contacts = world_.border_contacts();
  for (std::uint32_t i = 0; i < contacts.size(); ++i) contacts[i].outside_velocity = fade * outside_velocity_[i];
  if (late == 0) return;
  const double faded = std::max(0.0, 1.0 - static_cast<double>(late - 1) / config_.ratio);
  slow_down(world_.border_ghosts().span(), faded > 0 ? fade / faded : 0.0);
  result.status |= kWorldLate;
  if (late > kFreezeAfterCycles * config_.ratio) {
    world_.border_mode = physics::BorderMode::kFrozen;
    result.status |= kBorderFrozen;
  }
  const double lost_ticks = late - kWorldLostAfter_s / config_.step.dt;
  if (lost_ticks > 0) {
    result.status |= kWorldFade;
    result.force_scale = std::max(0.0, 1.0 - lost_ticks / kWorldFadeTicks);
  }
}

void SubWorld::aim_spring(const DeviceTarget& target) noexcept {
  auto& spring = world_.device_spring();
  const std::int32_t slot = world_.slot_of(config_.proxy);
  spring.enabled = slot >= 0;
  if (!spring.enabled) return;
  spring.slot = static_cast<std::uint32_t>(slot);
  spring.stiffness_N_per_m = target.engaged ? config_.stiffness_N_per_m : 0.0;
  spring.stiffness_Nm_per_rad = target.engaged ? config_.stiffness_Nm_per_rad : 0.0;
  spring.target = target.engaged ? target.pose : proxy_.pose;
  spring.target_velocity = target.engaged ? target.velocity : Twistd{};
}

void SubWorld::step_world(const DeviceTarget& target, std::uint32_t sub_steps, const physics::CutPredicate& cut,
                          SubWorldStep& result) noexcept {
  physics::StepSettings settings = config_.step;
  settings.sub_steps = sub_steps;
  aim_spring(target);
  const Posed held_at =
      world_.device_spring().enabled ? world_.bodies()[world_.device_spring().slot].motion.pose : Posed{};
  const double border_before_J = border_work_J();
  if (has_budget(world_.border_mode))
    world_.border_budget_J = state_.tank_J - state_.owed_J + std::max(0.0, tick_credit_J());
  world_.begin_step(settings);
  (void)physics::find_pairs_brute_force(world_.bounds(), world_.dynamic_pairs());
  result.report = world_.finish_step(settings, cut);
  state_.last_sub_steps = sub_steps;
  state_.border_work_J += result.report.border_joints_J;
  if (has_budget(world_.border_mode)) {
    put_in_tank(tick_credit_J() + border_before_J - border_work_J());
    if (!(state_.tank_J > 0)) result.status |= kBorderSpent;
  }

  const Wrenchd& impulse = world_.device_spring().step_impulse;
  state_.cycle_impulse.force += impulse.force;
  state_.cycle_impulse.torque += impulse.torque;
  const double rate = -1.0 / settings.dt;
  const Wrenchd& felt = result.report.felt;  // of effects that are the hand's alone
  if (target.engaged) result.on_device = {impulse.force * rate + felt.force, impulse.torque * rate + felt.torque};
  if (world_.device_spring().enabled) {
    proxy_ = world_.bodies()[world_.device_spring().slot].motion;
    // The mean wrench along the way of the tick.
    const Vec3d turn = small_rotation_vector(proxy_.pose.rotation * conjugate(held_at.rotation));
    state_.proxy_work_J -=
        rate * (dot(impulse.force, proxy_.pose.position - held_at.position) + dot(impulse.torque, turn));
  }
  if (proxy_touches()) result.status |= kProxyContact;
  if (result.report.capacity_bits != 0) result.status |= kCapacityExceeded;
  if (result.report.cut_sweep != physics::kNeverCut) result.status |= kSolverCut;
}

// The proxy as the device feels it is that of the global world, one cycle behind.
void SubWorld::step_interpolated(const DeviceTarget& target, SubWorldStep& result) noexcept {
  proxy_ = state_.interpolation.proxy_in(state_.ticks_in_cycle, config_.ratio, config_.step.dt);
  if (target.engaged) feel_proxy(target, result);
}

// The proxy as the planes of its contacts let it follow the device, without mass; its effort on the bodies is stored.
void SubWorld::step_on_planes(const DeviceTarget& target, SubWorldStep& result) noexcept {
  const std::int32_t slot = world_.slot_of(config_.proxy);
  if (slot < 0) return;
  proxy_.velocity = {};
  if (target.engaged) {
    const PlaneCoupling::Tick tick{
        config_.scheme, config_.step.dt, state_.ticks_in_cycle, config_.ratio,
        config_.stiffness_N_per_m > 0 ? config_.damping_Ns_per_m / config_.stiffness_N_per_m : 0.0};
    const HeldProxy held = planes_.follow(target, tick);
    proxy_ = {{held.position, target.pose.rotation}, {held.velocity, target.velocity.angular}};
    if (held.touches) result.status |= kProxyContact;
    feel_proxy(target, result);
  } else {
    planes_.let_go();
  }
  world_.bodies()[static_cast<std::uint32_t>(slot)].motion = proxy_;
}

// The coupling's spring and damper between the device and a proxy that no world simulates here.
void SubWorld::feel_proxy(const DeviceTarget& target, SubWorldStep& result) noexcept {
  const Vec3d stretch = target.pose.position - proxy_.pose.position;
  const Vec3d twist = small_rotation_vector(target.pose.rotation * conjugate(proxy_.pose.rotation));
  const Wrenchd on_proxy{config_.stiffness_N_per_m * stretch +
                             config_.damping_Ns_per_m * (target.velocity.linear - proxy_.velocity.linear),
                         config_.stiffness_Nm_per_rad * twist +
                             config_.damping_Nms_per_rad * (target.velocity.angular - proxy_.velocity.angular)};
  state_.cycle_impulse.force += config_.step.dt * on_proxy.force;
  state_.cycle_impulse.torque += config_.step.dt * on_proxy.torque;
  result.on_device = {-on_proxy.force, -on_proxy.torque};
}

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
  out.put(outside_velocity_.size());
  out.put_all(outside_velocity_.span());
  out.put(proxy_);
  out.put(state_);
  buffer_.save(out);
  planes_.save(out);
}

bool SubWorld::restore(ByteReader& in) noexcept {
  std::uint32_t count = 0;
  if (!world_.restore(in)) return false;
  in.get(count);
  if (!in.ok() || count != world_.border_contacts().size()) return false;
  outside_velocity_.resize(count);
  in.get_all(outside_velocity_.span());
  in.get(proxy_);
  in.get(state_);
  if (!buffer_.restore(in, world_) || !planes_.restore(in)) return false;
  border_count_ = world_.border_contacts().size();
  world_.near_triangles = {};
  return in.ok() && state_.last_sub_steps > 0;
}

std::size_t SubWorld::save_size_bound() const noexcept {
  return world_.save_size_bound() + sizeof(std::uint32_t) + outside_velocity_.capacity() * sizeof(Vec3d) +
         sizeof(proxy_) + sizeof(state_) + BorderBuffer::kMostBytes + PlaneCoupling::kMostBytes;
}

}  // namespace tactus::haptics
