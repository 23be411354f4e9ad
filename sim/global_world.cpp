#include "sim/global_world.h"

#include <fmt/format.h>

namespace tactus::sim {
namespace {

using haptics::CouplingScheme;
using haptics::SubWorldReport;
using haptics::WorldSnapshot;
using physics::Body;
using physics::BodyKind;

// Enough for impulses to come through a stack of some twenty bodies.
constexpr unsigned kForeseenSteps = 5;

// A packed cube has 26 neighbours, half of them its own pairs, and touches 6: twice of that before anything is lost.
constexpr std::uint32_t kPairsPerBody = 16;
constexpr std::uint32_t kContactsPerBody = 8;
constexpr std::uint32_t kFewestPairs = 256;
constexpr std::uint32_t kFewestContacts = 256;

std::uint32_t count_bodies(const Scene& scene, BodyKind kind) noexcept {
  return static_cast<std::uint32_t>(
      std::count_if(scene.bodies.begin(), scene.bodies.end(), [&](const Body<double>& b) { return b.kind == kind; }));
}

physics::Capacities capacities_for(const Scene& scene) noexcept {
  const std::uint32_t bodies = count_bodies(scene, BodyKind::kDynamic);
  return {bodies, count_bodies(scene, BodyKind::kFixed), std::max(kFewestPairs, kPairsPerBody * bodies),
          std::max(kFewestContacts, kContactsPerBody * bodies), 0};
}

physics::StepSettings<double> settings_for(const Scene& scene, const GlobalOptions& options) noexcept {
  physics::StepSettings<double> settings;
  settings.dt = options.reach.ratio * options.reach.tick_period_s;
  settings.sub_steps = options.reach.ratio * scene.solver.global_sub_steps_per_tick;
  settings.relax_sweeps = scene.solver.relax_sweeps;
  settings.contact_hertz = scene.solver.contact_hertz;
  settings.contact_damping_ratio = scene.solver.contact_damping_ratio;
  settings.gravity = scene.effects.gravity ? scene.gravity_m_per_s2 : Vec3d{};
  settings.friction = scene.effects.friction;
  settings.gyroscopic = scene.effects.gyroscopic;
  return settings;
}

double energy_of(const Body<double>& body, const Vec3d& gravity) noexcept {
  const auto& [pose, velocity] = body.motion;
  const Vec3d w = rotate_inverse(pose.rotation, velocity.angular);
  return 0.5 * (body.mass * norm_squared(velocity.linear) + dot(w, scale(body.inertia, w))) -
         body.mass * body.gravity_scale * dot(gravity, pose.position);
}

}  // namespace

Status check_global_options(const Scene& scene, const GlobalOptions& options) {
  if (options.coupling == CouplingScheme::kDirect)
    return Status::error("direct coupling runs the whole world at the haptic rate: it has no global world");
  if (options.reach.ratio == 0 || !(options.reach.tick_period_s > 0))
    return Status::error("the ratio must be 1 or more, and the tick period above 0 s");
  if (scene.solver.global_sub_steps_per_tick == 0)
    return Status::error("solver.global_sub_steps_per_tick is 0: give 1 or more");
  if (scene.proxy >= scene.bodies.size() || scene.bodies[scene.proxy].kind != BodyKind::kDynamic)
    return Status::error("the scene's proxy must be one of its dynamic bodies");
  if (options.extraction.cap == 0 || options.extraction.cap > haptics::kMaxMembers)
    return Status::error(
        fmt::format("{} members asked for: 1 to {} are possible", options.extraction.cap, haptics::kMaxMembers));
  const std::uint32_t bodies = count_bodies(scene, BodyKind::kDynamic);
  if (options.extraction.all_members && bodies > haptics::kMaxMembers)
    return Status::error(
        fmt::format("every body was asked to be a member, but the scene has {} moving bodies and a "
                    "sub-world holds {}",
                    bodies, haptics::kMaxMembers));
  return Status::good();
}

GlobalWorld::GlobalWorld(const Scene& scene, const GlobalOptions& options)
    : options_(options),
      settings_(settings_for(scene, options)),
      world_(capacities_for(scene), scene.hulls),
      hulls_(scene.hulls),
      grid_(capacities_for(scene).bodies),
      graph_(capacities_for(scene).bodies, capacities_for(scene).contacts),
      border_log_(capacities_for(scene).contacts),
      start_(capacities_for(scene).bodies),
      bounds_(capacities_for(scene).bodies),
      free_(capacities_for(scene).bodies) {
  for (const auto& body : scene.bodies) TACTUS_CHECK(world_.insert(body), body.id, scene.bodies.size());
  touches_.reserve(capacities_for(scene).contacts);
  const std::int32_t proxy = world_.slot_of(scene.proxy);
  TACTUS_CHECK(proxy >= 0, scene.proxy, scene.bodies.size());
  const auto slot = static_cast<std::uint32_t>(proxy);
  devices_.push_back(
      {slot, Extraction(options.extraction, options.reach, world_.bodies(), slot, capacities_for(scene).contacts),
       world_.bodies()[slot].motion.pose});
  statistics_.bodies = static_cast<std::uint32_t>(world_.bodies().size());
  statistics_.fixed_bodies = static_cast<std::uint32_t>(world_.fixed_bodies().size());
}

void GlobalWorld::share_work(WorkerPool& pool) {
  world_.share_work(pool.executor());
  grid_.share_work(pool.executor(), pool.threads(), world_.dynamic_pairs().capacity());
}

void GlobalWorld::first_snapshot(WorldSnapshot& first, std::uint32_t device) noexcept {
  find_touches_at_rest();
  fill_snapshot(device, 0, haptics::kMaxMembers, first);
  if (options_.coupling == CouplingScheme::kSubWorld) foresee_border(device, first);
}

// Without impulses in G(0) what rests on outside bodies would fall for two cycles. So a few steps are tried, their
// border is kept, and everything else is taken back.
void GlobalWorld::foresee_border(std::uint32_t device, WorldSnapshot& first) noexcept {
  std::vector<std::byte> bytes(world_.save_size_bound());
  ByteWriter out(bytes);
  world_.save(out);
  TACTUS_CHECK(out.ok(), out.size(), bytes.size());
  const GlobalStatistics statistics = statistics_;
  const double time_s = time_s_;
  for (unsigned step = 0; step < kForeseenSteps; ++step) advance();
  first.dropped += border_log_.fill(world_.contacts(), world_.bodies(), start_,
                                    devices_[device].extraction.member_flags(), settings_.dt, first.border);
  ByteReader in(std::span<const std::byte>(bytes).first(out.size()));
  TACTUS_CHECK(world_.restore(in), out.size(), 0);
  statistics_ = statistics;
  time_s_ = time_s;
}

void GlobalWorld::step(const SubWorldReport& report, WorldSnapshot& next) noexcept {
  impose(0, report);
  advance();
  fill_snapshot(0, report.cycle + 1, report.member_budget, next);
}

void GlobalWorld::impose(std::uint32_t device_index, const SubWorldReport& report) noexcept {
  Device& device = devices_[device_index];
  if (options_.coupling == CouplingScheme::kInterpolation) {
    // The effort that the device stored over the cycle, all at once.
    if (is_finite(report.stored_effort)) world_.apply_impulse(device.proxy, report.stored_effort);
    device.reported_proxy = world_.bodies()[device.proxy].motion.pose;
    return;
  }
  impose_motion(device, report);
  if (options_.coupling == CouplingScheme::kSubWorld) {
    for (const auto& warm_start : report.warm_starts) world_.add_warm_start(warm_start);
    const HandBack back =
        hand_back_border(report.border.span(), device.extraction.member_flags(), options_.border_mode, world_);
    statistics_.handed_back_impulse_Ns += back.magnitude_Ns;
    statistics_.handed_back_energy_J += back.energy_J;
    statistics_.handed_back_skipped += back.skipped;
  }
  // The device goes on holding the proxy as it did on the mean of the last cycle; the next report corrects it.
  if (is_finite(report.mean_device_wrench)) world_.apply_wrench(device.proxy, report.mean_device_wrench);
}

// Pose and velocity of the members as they are, bit by bit; with the static coupling only the proxy's, since the
// others were frozen.
void GlobalWorld::impose_motion(Device& device, const SubWorldReport& report) noexcept {
  double before = 0, after = 0;
  for (const auto& member : report.members) {
    const std::int32_t found = world_.slot_of(member.id);
    if (found < 0) continue;
    const auto slot = static_cast<std::uint32_t>(found);
    if (options_.coupling == CouplingScheme::kStatic && slot != device.proxy) continue;
    if (!is_finite(member.motion.pose) || !is_finite(member.motion.velocity)) {
      ++statistics_.rejected_states;
      continue;
    }
    Body<double>& body = world_.bodies()[slot];
    before += energy_of(body, settings_.gravity);
    body.motion = member.motion;
    after += energy_of(body, settings_.gravity);
  }
  statistics_.imposed_energy_J += after - before;
  device.reported_proxy = world_.bodies()[device.proxy].motion.pose;
}

void GlobalWorld::advance() noexcept {
  const auto bodies = world_.bodies();
  for (std::size_t slot = 0; slot < bodies.size(); ++slot) start_[slot] = bodies[slot].motion.pose;
  world_.begin_step(settings_);
  if (!grid_.find(world_.bounds(), world_.dynamic_pairs())) statistics_.capacity_bits |= physics::kPairsFull;
  const auto report = world_.finish_step(settings_);
  time_s_ += settings_.dt;
  find_touches();

  auto& s = statistics_;
  ++s.steps;
  s.pairs = report.pairs, s.contacts = report.contacts, s.points = report.points;
  s.most_pairs = std::max(s.most_pairs, report.pairs);
  s.most_contacts = std::max(s.most_contacts, report.contacts);
  s.capacity_bits |= report.capacity_bits;
  s.deepest_m = std::max(s.deepest_m, report.deepest_m);
}

void GlobalWorld::find_touches() noexcept {
  touches_.clear();
  for (const auto& contact : world_.contacts())
    if (!contact.b_fixed && contact.touching()) touches_.push_back(touch_of(contact, world_.bodies()));
  graph_.build(static_cast<std::uint32_t>(world_.bodies().size()), touches_);
}

// Before the first step nothing has pressed yet: what is within the tolerance counts as touching.
void GlobalWorld::find_touches_at_rest() noexcept {
  const std::span<const Body<double>> bodies = world_.bodies();
  for (std::size_t slot = 0; slot < bodies.size(); ++slot)
    bounds_[slot] = physics::bounds_of(bodies[slot].shape, bodies[slot].motion.pose, options_.touch_tolerance_m);
  auto& pairs = world_.dynamic_pairs();
  pairs.clear();
  if (!grid_.find(bounds_, pairs)) statistics_.capacity_bits |= physics::kPairsFull;
  std::sort(pairs.begin(), pairs.end(), [](const physics::SlotPair& p, const physics::SlotPair& q) {
    const auto low = [](const physics::SlotPair& x) { return std::min(x.a, x.b); };
    const auto high = [](const physics::SlotPair& x) { return std::max(x.a, x.b); };
    return low(p) != low(q) ? low(p) < low(q) : high(p) < high(q);
  });
  touches_.clear();
  for (const auto& pair : pairs) {
    const std::uint32_t a = std::min(pair.a, pair.b), b = std::max(pair.a, pair.b);
    physics::AxisCache cache;
    const auto manifold = physics::collide(bodies[a].shape, bodies[a].motion.pose, bodies[b].shape,
                                           bodies[b].motion.pose, options_.touch_tolerance_m, cache, hulls_);
    if (manifold.count == 0 || touches_.size() == touches_.capacity()) continue;
    Vec3d from_a;
    for (std::uint32_t i = 0; i < manifold.count; ++i) from_a += manifold.points[i].from_a;
    touches_.push_back({a, b, bodies[a].motion.pose.position + from_a * (1.0 / manifold.count), manifold.normal});
  }
  pairs.clear();
  graph_.build(static_cast<std::uint32_t>(bodies.size()), touches_);
}

void GlobalWorld::fill_snapshot(std::uint32_t device_index, std::uint64_t cycle, std::uint32_t budget,
                                WorldSnapshot& next) noexcept {
  Device& device = devices_[device_index];
  std::fill(free_.begin(), free_.end(), std::uint8_t{1});
  for (const Device& other : devices_)
    if (&other != &device)
      for (const std::uint32_t slot : other.extraction.members()) free_[slot] = 0;
  // With the interpolation the device feels the proxy alone.
  if (options_.coupling == CouplingScheme::kInterpolation) budget = 1;
  const auto members = device.extraction.choose(world_.bodies(), graph_, device.reported_proxy, budget, free_);

  next.cycle = cycle;
  next.global_time_s = time_s_;
  next.component = device.extraction.statistics().component;
  next.dropped = 0;
  next.proxy = world_.bodies()[device.proxy].motion;
  next.members.clear();
  for (const std::uint32_t slot : members) TACTUS_CHECK(next.members.try_push(world_.bodies()[slot].id), slot, 0);
  next.border.clear();
  next.warm_starts.clear();
  fill_joiners(device, next);
  if (options_.coupling == CouplingScheme::kSubWorld) {
    fill_warm_starts(device, next);
    if (cycle > 0)
      next.dropped += border_log_.fill(world_.contacts(), world_.bodies(), start_, device.extraction.member_flags(),
                                       settings_.dt, next.border);
  }
  count(device, next);
}

// Whole bodies, bit by bit. Frozen members (static coupling) come anew every time, but for the proxy, which is the
// sub-world's.
void GlobalWorld::fill_joiners(const Device& device, WorldSnapshot& next) noexcept {
  next.joiners.clear();
  const bool renew = options_.coupling == CouplingScheme::kStatic;
  for (const std::uint32_t slot : device.extraction.members())
    if (device.extraction.is_joiner(slot) || (renew && slot != device.proxy))
      TACTUS_CHECK(next.joiners.try_push(world_.bodies()[slot]), slot, 0);
}

// Of joiners' contacts with members and with static geometry: those go on in the sub-world as they were here.
void GlobalWorld::fill_warm_starts(const Device& device, WorldSnapshot& next) noexcept {
  const double sub_step_s = settings_.dt / settings_.sub_steps;
  const auto& e = device.extraction;
  for (const auto& contact : world_.contacts()) {
    const bool inside = e.is_member(contact.slot_a) && (contact.b_fixed || e.is_member(contact.slot_b));
    const bool joins = inside && (e.is_joiner(contact.slot_a) || (!contact.b_fixed && e.is_joiner(contact.slot_b)));
    if (joins && !next.warm_starts.try_push(physics::World<double>::warm_start_of(contact, sub_step_s))) ++next.dropped;
  }
}

void GlobalWorld::count(const Device& device, const WorldSnapshot& next) noexcept {
  auto& s = statistics_;
  const auto& e = device.extraction.statistics();
  s.most_members = std::max(s.most_members, next.members.size());
  s.most_component = std::max(s.most_component, e.component);
  s.most_border_points = std::max(s.most_border_points, next.border.size());
  s.most_close_left_out = std::max(s.most_close_left_out, e.close_left_out);
  s.joins += e.joins;
  s.leaves += e.leaves;
  s.dropped_entries += next.dropped;
}

}  // namespace tactus::sim
