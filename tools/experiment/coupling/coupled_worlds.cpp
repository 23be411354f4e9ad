#include "tools/experiment/coupling/coupled_worlds.h"

#include "tools/experiment/coupling/scheme.h"
#include "tools/experiment/timing.h"
#include "tools/session/session.h"

namespace tactus::experiment {
namespace {

void add_motion(const physics::Body& body, EnergySample& sum) noexcept {
  sum.kinetic_J += kinetic_energy(body);
  sum.speed_squared += norm_squared(body.motion.velocity.linear);
}

}  // namespace

CoupledWorlds::CoupledWorlds(const sim::Scene& scene, const session::RunOptions& options,
                             const haptics::DeviceProperties& device)
    : config_(session::loop_config(scene, options, device).sub_world), coupling_(traits_of(options.coupling)) {
  std::vector<physics::Body> fixed;
  for (const auto& body : scene.bodies) (body.kind == physics::BodyKind::kFixed ? fixed : at_rest_).push_back(body);
  // Capacity for all bodies, so that the state of a direct run fits.
  session::RunOptions direct = options;
  direct.coupling = kDirectScheme.coupling;
  const bool is_direct = !coupling_.global_world;
  if (is_direct || at_rest_.size() <= haptics::kMaxMembers)
    config_.capacities = session::loop_config(scene, direct, device).sub_world.capacities;
  sub_world_ = std::make_unique<haptics::SubWorld>(config_, fixed);
  if (is_direct) return;
  global_ = std::make_unique<sim::GlobalWorld>(scene, session::global_options(scene, options, device));
  server_.emplace(*global_, exchange_);
}

void CoupledWorlds::start_at_rest() {
  if (exchanges())
    server_->publish_first();
  else
    sub_world_->set_members(at_rest_);
}

void CoupledWorlds::start_from(const WorldKeyframe& before, const WorldKeyframe& now, const Wrenchd& on_proxy,
                               const Vec3d& shift) {
  ByteReader in(now.state);
  TACTUS_CHECK(sub_world_->restore(in), now.tick, now.state.size());
  if (!exchanges()) {
    if (shift != Vec3d{}) shift_proxy(now, shift);
    return;
  }
  on_proxy_before_ = on_proxy;
  global_->set_state(before.bodies, before.contacts);
  haptics::SubWorldReport& report = exchange_.reports.writing(0);
  report = {};
  report.mean_device_wrench = on_proxy;
  report.device = device_that_holds(before, on_proxy);
  global_->impose(0, report);
  haptics::WorldSnapshot& first = exchange_.snapshots.writing(0);
  if (coupling_.model ==
      haptics::LocalModel::kInterpolatedProxy) {  // which interpolates from the proxy's pose one cycle ago
    global_->fill_snapshot(0, 1, haptics::kMaxMembers, first);
    first.warm_starts.clear();
    sub_world_->synchronise(first, report);
  }
  global_->advance();
  global_->set_state(now.bodies, {});
  global_->fill_snapshot(0, 1, haptics::kMaxMembers, first);
  first.cycle = 0;
  first.warm_starts.clear();  // the members already exist, with their contact impulses
  device_before_ = device_that_holds(now, on_proxy);
  if (coupling_.proxy_planes > 0) sub_world_->synchronise(first, report);  // planes of the previous cycle
  exchange_.snapshots.publish(0);
}

// Target of a device that moves with the proxy and exerts this wrench.
haptics::DeviceTarget CoupledWorlds::device_that_holds(const WorldKeyframe& at, const Wrenchd& on_proxy) const {
  for (const auto& body : at.bodies) {
    if (body.id != config_.proxy) continue;
    const auto& [pose, velocity] = body.motion;
    const Vec3d stretch = on_proxy.force * (1 / config_.gains.stiffness_N_per_m);
    const Vec3d twist = on_proxy.torque * (1 / config_.gains.stiffness_Nm_per_rad);
    return {true, {pose.position + stretch, quat_from_rotation_vector(twist) * pose.rotation}, velocity};
  }
  return {};
}

// Removes the proxy and adds it again at the new place with its former contacts.
void CoupledWorlds::shift_proxy(const WorldKeyframe& now, const Vec3d& shift) {
  haptics::WorldSnapshot& snapshot = exchange_.snapshots.writing(0);  // only start_from publishes it
  haptics::SubWorldReport& report = exchange_.reports.writing(0);
  snapshot = {};
  for (const auto& body : now.bodies)
    if (body.id != config_.proxy) TACTUS_CHECK(snapshot.members.try_push(body.id), body.id, 0);
  sub_world_->synchronise(snapshot, report);
  snapshot.members.clear();
  for (const auto& body : now.bodies) {
    TACTUS_CHECK(snapshot.members.try_push(body.id), body.id, 0);
    if (body.id != config_.proxy) continue;
    auto moved = body;
    moved.motion.pose.position += shift;
    TACTUS_CHECK(snapshot.joiners.try_push(moved), body.id, 0);
  }
  for (const auto& contact : now.contacts)
    if (contact.key.low() == config_.proxy || contact.key.high() == config_.proxy)
      (void)snapshot.warm_starts.try_push(contact);
  sub_world_->synchronise(snapshot, report);
}

bool CoupledWorlds::at_synchronisation() const noexcept {
  return !exchanges() || next_cycle_ == 0 || sub_world_->ticks_in_cycle() >= config_.ratio;
}

bool CoupledWorlds::synchronise() {
  if (!exchanges() || !at_synchronisation()) return false;
  const haptics::WorldSnapshot* snapshot = exchange_.snapshots.try_read(next_cycle_);
  TACTUS_CHECK(snapshot != nullptr, next_cycle_, server_->next_report());  // serve() was called in the last cycle
  haptics::SubWorldReport& report = exchange_.reports.writing(next_cycle_);
  component_ = snapshot->component;
  sub_world_->synchronise(*snapshot, report);
  report.member_budget = haptics::kMaxMembers;
  if (next_cycle_ == 0) {
    report.mean_device_wrench = on_proxy_before_;
    report.device = device_before_;
  }
  exchange_.reports.publish(next_cycle_++);
  return true;
}

void CoupledWorlds::serve() { (void)server_->serve(); }

const haptics::SubWorldStep& CoupledWorlds::step(const haptics::DeviceTarget& target) {
  step_ = sub_world_->step(target, config_.step.sub_steps, {});
  return step_;
}

const haptics::SubWorldStep& CoupledWorlds::tick(const haptics::DeviceTarget& target) {
  if (synchronise()) serve();
  return step(target);
}

// True if the member's valid state is that of the haptic side.
bool CoupledWorlds::haptic_side_moves(BodyId member) const noexcept {
  return coupling_.imposes_motion && (!coupling_.members_frozen || member == config_.proxy);
}

EnergySample CoupledWorlds::motion() const noexcept {
  EnergySample sum;
  const auto& inner = sub_world_->world();
  for (const auto& body : inner.bodies())
    if (haptic_side_moves(body.id)) add_motion(body, sum);
  if (!exchanges()) return sum;
  for (const auto& body : global_->bodies())
    if (inner.find(body.id) == nullptr || !haptic_side_moves(body.id)) add_motion(body, sum);
  return sum;
}

// Members from the haptic side, the others from the global world.
void CoupledWorlds::bodies(std::vector<physics::Body>& all) const {
  const auto& inner = sub_world_->world();
  all.clear();
  if (!exchanges()) {
    all.assign(inner.bodies().begin(), inner.bodies().end());
    return;
  }
  for (const auto& body : global_->bodies()) {
    const physics::Body* member = coupling_.border || body.id == config_.proxy ? inner.find(body.id) : nullptr;
    all.push_back(member != nullptr ? *member : body);
    if (member == nullptr && body.id == config_.proxy && next_cycle_ > 0) all.back().motion = sub_world_->proxy();
  }
}

double CoupledWorlds::springs_J() const noexcept {
  if (exchanges()) return global_->springs_J();
  return sim::springs_J(sub_world_->world(), config_.step.contact_hertz, config_.step.slop);
}

double CoupledWorlds::held_by_border_J() const noexcept {
  if (!exchanges() || !physics::traits_of(config_.border_mode).has_tank) return 0;
  return std::max(0.0, global_->statistics().border_work_J - sub_world_->border_work_J() - sub_world_->push_out_J() -
                           sub_world_->corrected_J());
}

WorldKeyframe CoupledWorlds::keyframe(std::uint64_t tick, bool every_bit) const {
  WorldKeyframe keyframe;
  keyframe.tick = tick;
  const auto& world = sub_world_->world();
  keyframe.bodies.assign(world.bodies().begin(), world.bodies().end());
  const double sub_step_s = config_.step.dt / config_.step.sub_steps;
  for (const auto& contact : world.contacts())
    keyframe.contacts.push_back(physics::World::warm_start_of(contact, sub_step_s));
  if (!every_bit) return keyframe;
  keyframe.state.resize(sub_world_->save_size_bound());
  ByteWriter out(keyframe.state);
  sub_world_->save(out);
  keyframe.state.resize(out.size());
  return keyframe;
}

double timed_tick_us(CoupledWorlds& worlds, const haptics::DeviceTarget& target, const std::function<void()>& serve) {
  bool synchronised = false;
  const double before_us = cpu_time_us([&] { synchronised = worlds.synchronise(); });
  if (synchronised) serve();
  return before_us + cpu_time_us([&] { worlds.step(target); });
}

}  // namespace tactus::experiment
