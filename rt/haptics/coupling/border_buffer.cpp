#include "rt/haptics/coupling/border_buffer.h"

#include <algorithm>
#include <functional>

#include "rt/physics/contact/find_contacts.h"

namespace tactus::haptics {

namespace {

// A contact whose friction force exceeds this share of its friction limit counts as sliding.
constexpr double kHolds = 0.95;

// A cycle's share of the global world's impulses in those between a buffer body and an inner member.
constexpr double kMixedShare = 0.125;

// Mean difference of a body's accelerations in the two worlds that a lasting load explains: an eighth of gravity.
constexpr double kLasting_m_per_s2 = 9.80665 / 8;

// The hand's impulse in the sub-world beyond that in the global world.
Wrenchd hand_beyond(const WorldSnapshot& snapshot, const BorderBuffer::Cycle& cycle) noexcept {
  return cycle.hand_impulse - snapshot.hand_impulse;
}

// The point of the body at which friction holds it and the proxy together.
struct Hold {
  bool holds{false};
  Vec3d point;   // m, world
  Vec3d normal;  // of the contact that presses hardest
};

Hold hold_between(const physics::World& world, BodyId proxy, physics::SlotIndex slot) noexcept {
  const auto& body = world.body(slot);
  const auto contacts = physics::find_contacts(world.contacts(), proxy, body.id);
  Hold hold;
  Vec3d friction, arm;
  double pressed = 0, hardest = -1, coefficient = 0;
  for (const auto& contact : contacts) {
    double here = 0;
    for (std::uint32_t i = 0; i < contact.count; ++i) {
      const auto& point = contact.points[i];
      friction += point.total_friction;
      here += point.total_normal_impulse;
      arm += point.total_normal_impulse * (contact.slot_a == number_of(slot) ? point.from_a : point.from_b);
    }
    pressed += here;
    coefficient = contact.friction;  // the same for all contacts of a pair
    if (here > hardest) hold.normal = contact.normal;
    hardest = std::max(hardest, here);
  }
  hold.holds = norm(friction) < kHolds * coefficient * pressed;
  if (hold.holds) hold.point = body.motion.pose.position + arm * (1 / pressed);
  return hold;
}

}  // namespace

double BorderBuffer::impulse_share(PairKey key) const noexcept {
  return key.with_fixed() || holds(key.low()) == holds(key.high()) ? 1.0 : kMixedShare;
}

// Does the velocity of an inner member differ from that in the global world by more than a lasting load explains?
bool BorderBuffer::is_impact(const WorldSnapshot& snapshot, const Cycle& cycle,
                             const physics::World& world) const noexcept {
  if (!(cycle.duration_s > 0) || bodies_.empty()) return false;
  for (const MemberMotion& renewed : snapshot.renewed) {
    const physics::Body* body = world.find(renewed.id);
    if (body == nullptr || holds(renewed.id)) continue;
    Vec3d apart = body->motion.velocity.linear - renewed.motion.velocity.linear;
    if (renewed.id == cycle.proxy) apart -= hand_beyond(snapshot, cycle).force * (1 / body->mass);
    if (norm(apart) > kLasting_m_per_s2 * cycle.duration_s) return true;
  }
  return false;
}

void BorderBuffer::adopt_all(const WorldSnapshot& snapshot, const Cycle& cycle, physics::World& world,
                             Adopted& adopted) const noexcept {
  adopted.all_members = true;
  for (const MemberMotion& renewed : snapshot.renewed) {
    const std::optional<physics::SlotIndex> slot = world.slot_of(renewed.id);
    if (!slot) continue;
    auto& body = world.body(*slot);
    adopted.gained_J -= kinetic_energy(body);
    body.motion = renewed.motion;
    if (renewed.id == cycle.proxy) world.apply_impulse(*slot, hand_beyond(snapshot, cycle));
    adopted.gained_J += kinetic_energy(body);
  }
}

void BorderBuffer::adopt_buffer(const WorldSnapshot& snapshot, BodyId proxy, physics::World& world,
                                Adopted& adopted) const noexcept {
  double held = 0;
  for (const MemberMotion& renewed : snapshot.renewed) {
    const std::optional<physics::SlotIndex> slot = world.slot_of(renewed.id);
    if (!slot || !holds(renewed.id)) continue;
    auto& body = world.body(*slot);
    const Hold hold = hold_between(world, proxy, *slot);
    const Posed before = body.motion.pose;
    adopted.gained_J -= kinetic_energy(body);
    body.motion = renewed.motion;
    adopted.gained_J += kinetic_energy(body);
    if (!hold.holds) continue;
    const Vec3d moved = body.motion.pose * (inverse(before) * hold.point) - hold.point;
    adopted.proxy_carried += moved - dot(moved, hold.normal) * hold.normal;
    held += 1;
  }
  if (held > 0) adopted.proxy_carried *= 1 / held;
}

BorderBuffer::Adopted BorderBuffer::adopt(const WorldSnapshot& snapshot, const Cycle& cycle,
                                          physics::World& world) noexcept {
  Adopted adopted;
  if (is_impact(snapshot, cycle, world))
    adopt_all(snapshot, cycle, world, adopted);
  else
    adopt_buffer(snapshot, cycle.proxy, world, adopted);
  bodies_.clear();
  for (const BodyId id : snapshot.buffer)
    if (world.find(id) != nullptr) (void)bodies_.try_push(id);  // cannot fail: members only
  return adopted;
}

void BorderBuffer::save(ByteWriter& out) const noexcept {
  out.put(bodies_.size());
  out.put_all(bodies_.span());
}

bool BorderBuffer::restore(ByteReader& in, const physics::World& world) noexcept {
  clear();
  std::uint32_t count = 0;
  in.get(count);
  if (!in.ok() || count > kMaxMembers) return false;
  bodies_.resize(count);
  in.get_all(bodies_.span());
  if (!in.ok() || std::adjacent_find(bodies_.begin(), bodies_.end(), std::greater_equal<>()) != bodies_.end())
    return false;
  return std::all_of(bodies_.begin(), bodies_.end(), [&](BodyId id) { return world.find(id) != nullptr; });
}

}  // namespace tactus::haptics
