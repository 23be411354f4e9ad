#include "sim/island_manager.h"

#include <algorithm>
#include <utility>

#include "rt/base/hash.h"

namespace tactus::sim {

using physics::Aabb;
using physics::Body;

IslandManager::IslandManager(const SleepRule& rule, const World& world, std::uint32_t max_contacts)
    : rule_(rule),
      bodies_(std::vector<Body>(world.bodies().begin(), world.bodies().end())),
      awake_(bodies_.size()),
      slow_steps_(bodies_.size(), 0),
      island_of_(bodies_.size(), kAwake),
      next_body_(bodies_.size(), kNoBodyIndex),
      first_sleeping_(bodies_.size(), kNone),
      is_marked_(bodies_.size(), 0),
      max_sleeping_(rule.enabled ? max_contacts : 0),
      grid_(static_cast<std::uint32_t>(rule.enabled ? bodies_.size() : 0)),
      parents_(bodies_.size()) {
  for (const BodyIndex body : bodies_.indices()) awake_[number_of(body)] = body;
  stays_.reserve(bodies_.size());
  apart_.reserve(bodies_.size());
  if (!rule.enabled) return;
  marked_.reserve(bodies_.size());
  woken_.reserve(bodies_.size());
  merge_.reserve(bodies_.size());
  returning_.reserve(bodies_.size());
  sleeping_contacts_.reserve(max_sleeping_);
}

std::optional<BodyIndex> IslandManager::index_of(BodyId id) const noexcept {
  const auto at =
      std::lower_bound(bodies_.begin(), bodies_.end(), id, [](const Body& b, BodyId i) { return b.id < i; });
  if (at == bodies_.end() || at->id != id) return std::nullopt;
  return BodyIndex{static_cast<std::uint32_t>(at - bodies_.begin())};
}

// --- waking

// Adds the island of a sleeping body to those to wake, once. False if the body is awake.
bool IslandManager::mark(BodyIndex body) noexcept {
  const BodyIndex island = island_of_[body];
  if (island == kAwake) return false;
  if (is_marked_[island] == 0) marked_.push_back(island);
  is_marked_[island] = 1;
  return true;
}

bool IslandManager::wake(BodyIndex body, World& world) noexcept { return mark(body) && wake_marked(world); }

bool IslandManager::wake_in(const Aabb& box, World& world) noexcept {
  if (grid_.size() == 0) return false;
  grid_.find(box, [this](std::uint32_t body) noexcept { mark(BodyIndex{body}); });
  return wake_marked(world);
}

bool IslandManager::wake_touched(World& world) noexcept {
  if (grid_.size() == 0) return false;
  for (const Aabb& box : world.bounds())
    grid_.find(box, [this](std::uint32_t body) noexcept { mark(BodyIndex{body}); });
  return wake_marked(world);
}

bool IslandManager::wake_marked(World& world) noexcept {
  if (marked_.empty()) return false;
  woken_.clear();
  returning_.clear();
  for (const BodyIndex island : marked_) {
    is_marked_[island] = 0;
    for (BodyIndex body = island; body != kNoBodyIndex; body = next_body_[body]) {
      woken_.push_back(body);
      island_of_[body] = kAwake;
      slow_steps_[body] = 0;
      grid_.remove(number_of(body));
    }
    for (std::uint32_t at = first_sleeping_[island]; at != kNone;) {
      (void)world.add_warm_start(sleeping_contacts_[at].warm_start);  // if it does not fit, the contact starts cold
      const std::uint32_t next = sleeping_contacts_[at].next;
      sleeping_contacts_[at].next = free_sleeping_;
      free_sleeping_ = at;
      at = next;
    }
  }
  marked_.clear();
  std::sort(woken_.begin(), woken_.end());
  for (const BodyIndex body : woken_) returning_.push_back(bodies_[body]);
  TACTUS_CHECK(world.insert(returning_), returning_.size(), awake_.size());
  merge_.resize(awake_.size() + woken_.size());
  std::merge(awake_.begin(), awake_.end(), woken_.begin(), woken_.end(), merge_.begin());
  awake_.swap(merge_);
  woke_up_ += woken_.size();
  return true;
}

// Islands of the awake bodies, by overlapping bounds and joints.
physics::Islands IslandManager::find_islands(World& world) noexcept {
  physics::Islands islands({parents_.data(), awake_.size()});
  for (const auto& pair : world.dynamic_pairs()) islands.link(pair.a, pair.b);
  if (const auto* joints = world.effects().find<physics::Joints>())
    joints->for_each_link(std::as_const(world).bodies(),
                          [&islands](std::uint32_t a, std::uint32_t b, std::uint32_t) noexcept { islands.link(a, b); });
  return islands;
}

std::span<const std::uint8_t> IslandManager::find_coarse(BodySpan<const std::uint8_t> kept_awake,
                                                         std::span<const Aabb> regions, World& world) noexcept {
  const auto count = static_cast<std::uint32_t>(awake_.size());
  const auto bounds = world.bounds();
  physics::Islands islands = find_islands(world);
  stays_.assign(count, 0);
  for (std::uint32_t slot = 0; slot < count; ++slot)
    if (kept_awake[awake_[slot]] != 0 ||
        std::any_of(regions.begin(), regions.end(), [&](const auto& region) { return region.overlaps(bounds[slot]); }))
      stays_[islands.of(slot)] = 1;
  apart_.assign(count, 0);
  for (std::uint32_t slot = 0; slot < count; ++slot) apart_[slot] = stays_[islands.of(slot)] == 0 ? 1 : 0;
  return apart_;
}

// --- falling asleep

void IslandManager::follow(const World& world) noexcept {
  const auto moved = world.bodies();
  TACTUS_CHECK(moved.size() == awake_.size(), moved.size(), awake_.size());
  for (std::size_t slot = 0; slot < moved.size(); ++slot) {
    const BodyIndex body = awake_[slot];
    const auto& motion = bodies_[body].motion = moved[slot].motion;
    if (!rule_.enabled) continue;
    const double speed =
        norm(motion.velocity.linear) + norm(motion.velocity.angular) * physics::bounding_radius(bodies_[body].shape);
    slow_steps_[body] = speed < rule_.max_speed_m_per_s ? std::min(slow_steps_[body] + 1, rule_.steps) : 0;
  }
}

void IslandManager::count_resting_as_slow() noexcept {
  for (const BodyIndex body : bodies_.indices())
    if (bodies_[body].motion.velocity == Twistd{}) slow_steps_[body] = rule_.steps;
}

// The body's bounds as begin_step would compute them, so that a body which would wake it in the next step also keeps it
// awake.
Aabb IslandManager::bounds_at_rest(BodyIndex at, const Settings& settings) const noexcept {
  const Body& body = bodies_[at];
  const double fall = physics::fall_in_step(settings);
  physics::MotionBound bound;
  bound.fallen = std::abs(body.gravity_scale) * fall;
  return physics::bounds_of(body.shape, body.motion.pose, physics::growth_of(bound, fall, settings));
}

void IslandManager::put_to_sleep(BodySpan<const std::uint8_t> kept_awake, std::span<const Aabb> regions,
                                 const Settings& settings, double sub_step_s, World& world) noexcept {
  const auto slow = [this](BodyIndex body) noexcept { return slow_steps_[body] >= rule_.steps; };
  if (!rule_.enabled || std::none_of(awake_.begin(), awake_.end(), slow)) return;
  const auto count = static_cast<std::uint32_t>(awake_.size());
  physics::Islands islands = find_islands(world);
  stays_.assign(count, 0);  // by an island's lowest slot
  for (std::uint32_t slot = 0; slot < count; ++slot) {
    std::uint8_t& stays = stays_[islands.of(slot)];
    const BodyIndex body = awake_[slot];
    if (stays != 0) continue;
    if (!slow(body) || kept_awake[body] != 0) {
      stays = 1;
      continue;
    }
    const Aabb box = bounds_at_rest(body, settings);
    stays = std::any_of(regions.begin(), regions.end(), [&](const auto& region) { return region.overlaps(box); });
  }

  apart_.assign(count, 0);
  bool some = false;
  for (std::uint32_t slot = 0; slot < count; ++slot) {  // an island's lowest slot comes first
    const std::uint32_t root = islands.of(slot);
    if (stays_[root] != 0) continue;
    apart_[slot] = 1;
    some = true;
    put_body_to_sleep(awake_[slot], awake_[root], settings);
  }
  if (!some) return;
  for (const auto& contact : world.contacts())
    if (apart_[contact.slot_a] != 0) store_contact(contact, island_of_[awake_[contact.slot_a]], sub_step_s);
  world.remove(apart_);
  std::uint32_t kept = 0;
  for (std::uint32_t slot = 0; slot < count; ++slot)
    if (apart_[slot] == 0) awake_[kept++] = awake_[slot];
  fell_asleep_ += count - kept;
  awake_.resize(kept);
}

void IslandManager::put_body_to_sleep(BodyIndex at, BodyIndex island, const Settings& settings) noexcept {
  Body& body = bodies_[at];
  stopped_energy_J_ += kinetic_energy(body);
  body.motion.velocity = {};
  island_of_[at] = island;
  if (at == island) {
    next_body_[island] = kNoBodyIndex;
    first_sleeping_[island] = kNone;
  } else {
    next_body_[at] = next_body_[island];
    next_body_[island] = at;
  }
  grid_.insert(number_of(at), bounds_at_rest(at, settings));
}

void IslandManager::store_contact(const physics::Contact& contact, BodyIndex island, double sub_step_s) noexcept {
  std::uint32_t at = free_sleeping_;
  if (at != kNone) {
    free_sleeping_ = sleeping_contacts_[at].next;
  } else {
    if (sleeping_contacts_.size() == max_sleeping_) return;
    at = static_cast<std::uint32_t>(sleeping_contacts_.size());
    sleeping_contacts_.emplace_back();
  }
  sleeping_contacts_[at] = {World::warm_start_of(contact, sub_step_s), first_sleeping_[island]};
  first_sleeping_[island] = at;
}

// --- diagnostics

double IslandManager::potential_energy(const Vec3d& gravity) const noexcept {
  double sum = 0;
  for (const BodyIndex at : bodies_.indices()) {
    const Body& body = bodies_[at];
    if (is_asleep(at)) sum -= body.mass * body.gravity_scale * dot(gravity, body.motion.pose.position);
  }
  return sum;
}

std::uint64_t IslandManager::state_hash(std::uint64_t of_the_awake) const noexcept {
  if (asleep() == 0) return of_the_awake;
  Fnv1a hash;
  hash.add(of_the_awake);
  for (const BodyIndex body : bodies_.indices()) {
    if (!is_asleep(body)) continue;
    const auto& [position, rotation] = bodies_[body].motion.pose;
    hash.add(bodies_[body].id);
    for (const double x : {position.x, position.y, position.z, rotation.w, rotation.x, rotation.y, rotation.z})
      hash.add(x);
  }
  return hash.value();
}

}  // namespace tactus::sim
