#include "tools/library/state_view.h"

#include <algorithm>

#include "tools/library/values.h"

namespace tactus::library {
namespace {

BodyState to_state(const physics::BodyMotion& motion) noexcept {
  return {to_public(motion.pose.position), to_public(motion.pose.rotation), to_public(motion.velocity.linear),
          to_public(motion.velocity.angular)};
}

}  // namespace

void StateView::bind(const session::Session& session) {
  const sim::Scene& scene = session.scene;
  bodies.resize(scene.bodies.size());
  roles.resize(scene.bodies.size());
  for (const physics::Body& body : scene.bodies) {
    bodies[body.id] = to_state(body.motion);
    roles[body.id] = body.kind == physics::BodyKind::kFixed ? Role::kFixed : Role::kGlobal;
  }
  const physics::Capacities& capacities = session.loop->config().sub_world.capacities;
  members.clear();
  contacts.clear();
  border.clear();
  members.reserve(scene.bodies.size());
  contacts.reserve(std::size_t{capacities.contacts} * physics::kMaxManifoldPoints);
  border.reserve(capacities.border_contacts);
}

void StateView::look(const sim::GlobalWorld& world) {
  for (const physics::Body& body : world.bodies()) {
    bodies[body.id] = to_state(body.motion);
    roles[body.id] = world.is_asleep(body.id) ? Role::kAsleep : Role::kGlobal;
  }
  members.clear();
  for (const sim::BodyIndex member : world.extraction().members())
    members.push_back(world.bodies()[number_of(member)].id);
  std::ranges::sort(members);
  for (const BodyNumber member : members) roles[member] = Role::kMember;
}

void StateView::look(const session::Session& session) {
  if (session.global != nullptr) look(*session.global);
  place_members(session);
  list_contacts(session);
  list_border(session);
}

// The sub-world's state of the members is newer than the global world's.
void StateView::place_members(const session::Session& session) {
  if (session.stats.ticks == 0) return;
  const haptics::SubWorld& sub_world = session.loop->sub_world();
  for (const BodyNumber member : members)
    if (roles[member] == Role::kMember) roles[member] = Role::kGlobal;
  members.clear();
  for (const physics::Body& body : sub_world.world().bodies()) {
    bodies[body.id] = to_state(body.motion);
    roles[body.id] = Role::kMember;
    members.push_back(body.id);
  }
  const BodyNumber proxy = session.scene.proxy;
  bodies[proxy] = to_state(sub_world.proxy());
  roles[proxy] = Role::kMember;
  if (members.empty()) members.push_back(proxy);  // coupling schemes in which the sub-world is the proxy alone
}

void StateView::list_contacts(const session::Session& session) {
  contacts.clear();
  const physics::World& world = session.loop->sub_world().world();
  const double per_s = 1.0 / session.options.period_s();
  for (const physics::Contact& contact : world.contacts()) {
    const physics::Body& a = world.bodies()[contact.slot_a];
    const BodyNumber b = contact.b_fixed ? world.fixed_bodies()[contact.slot_b].id : world.bodies()[contact.slot_b].id;
    const Vec3d centre = world.last_poses()[contact.slot_a].position;
    for (std::uint32_t i = 0; i < contact.count; ++i) {
      const physics::ContactPoint& point = contact.points[i];
      if (!(point.total_normal_impulse > 0 || point.separation <= 0)) continue;
      if (contacts.size() == contacts.capacity()) return;
      contacts.push_back({a.id, b, to_public(centre + point.from_a), to_public(contact.normal),
                          point.total_normal_impulse * per_s, to_public(point.total_friction * per_s),
                          point.separation});
    }
  }
}

void StateView::list_border(const session::Session& session) {
  border.clear();
  const physics::World& world = session.loop->sub_world().world();
  const double per_s = 1.0 / session.options.period_s();
  for (const physics::BorderContact& contact : world.border_contacts()) {
    const physics::Body* inner = world.find(contact.member);
    if (inner == nullptr) continue;
    roles[contact.member] = Role::kBorder;
    if (contact.outside < roles.size() && roles[contact.outside] == Role::kGlobal)
      roles[contact.outside] = Role::kOutside;
    if (!(contact.step_normal_impulse > 0) || border.size() == border.capacity()) continue;
    const Posed& member = inner->motion.pose;
    border.push_back({contact.member, contact.outside, to_public(contact.point_on(member)), to_public(contact.normal),
                      contact.step_normal_impulse * per_s, to_public(contact.step_tangent_impulse * per_s)});
  }
}

void StateHandOver::take(const sim::GlobalWorld& world) noexcept {
  if (filled_.load(std::memory_order_acquire)) return;
  view_.look(world);
  filled_.store(true, std::memory_order_release);
}

bool StateHandOver::look(StateView& view) {
  if (!filled_.load(std::memory_order_acquire)) return false;
  std::ranges::copy(view_.bodies, view.bodies.begin());
  std::ranges::copy(view_.roles, view.roles.begin());
  view.members.assign(view_.members.begin(), view_.members.end());
  filled_.store(false, std::memory_order_release);
  return true;
}

}  // namespace tactus::library
