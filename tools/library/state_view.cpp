#include "tools/library/state_view.h"

#include <algorithm>

#include "sim/model/given_pose.h"
#include "tools/library/values.h"

namespace tactus::library {
namespace {

BodyState to_state(const sim::Scene& scene, BodyId body, const physics::BodyMotion& motion) noexcept {
  const Posed pose = sim::given_pose(scene, body, motion.pose);
  return {.position_m = to_public(pose.position),
          .rotation = to_public(pose.rotation),
          .velocity_m_per_s = to_public(motion.velocity.linear),
          .angular_velocity_rad_per_s = to_public(motion.velocity.angular)};
}

}  // namespace

void StateView::bind(Sessions sessions) {
  const sim::Scene& scene = sessions.front()->scene;
  scene_ = &scene;
  bodies.resize(scene.bodies.size());
  for (const physics::Body& body : scene.bodies) bodies[body.id] = to_state(scene, body.id, body.motion);
  hands.resize(sessions.size());
  for (std::size_t i = 0; i < sessions.size(); ++i) {
    Hand& hand = hands[i];
    hand.roles.resize(scene.bodies.size());
    for (const physics::Body& body : scene.bodies)
      hand.roles[body.id] = body.kind == physics::BodyKind::kFixed ? Role::kFixed : Role::kGlobal;
    const physics::Capacities& capacities = sessions[i]->loop->config().sub_world.capacities;
    hand.members.clear();
    hand.contacts.clear();
    hand.border.clear();
    hand.members.reserve(scene.bodies.size());
    hand.contacts.reserve(std::size_t{capacities.contacts} * physics::kMaxManifoldPoints);
    hand.border.reserve(capacities.border_contacts);
  }
}

void StateView::look(const sim::GlobalWorld& world) {
  for (const physics::Body& body : world.bodies()) bodies[body.id] = to_state(*scene_, body.id, body.motion);
  for (std::uint32_t i = 0; i < hands.size(); ++i) {
    Hand& hand = hands[i];
    for (const physics::Body& body : world.bodies())
      hand.roles[body.id] = world.is_asleep(body.id) ? Role::kAsleep : Role::kGlobal;
    hand.members.clear();
    for (const sim::BodyIndex member : world.extraction(i).members())
      hand.members.push_back(world.bodies()[number_of(member)].id);
    std::ranges::sort(hand.members);
    for (const BodyNumber member : hand.members) hand.roles[member] = Role::kMember;
  }
}

void StateView::look(Sessions sessions) {
  if (sessions.front()->global != nullptr) look(*sessions.front()->global);
  for (std::size_t i = 0; i < sessions.size(); ++i) {
    place_members(*sessions[i], hands[i]);
    list_contacts(*sessions[i], hands[i]);
    list_border(*sessions[i], hands[i]);
  }
}

// The sub-world's state of the members is newer than the global world's.
void StateView::place_members(const session::Session& session, Hand& hand) {
  if (session.stats.ticks == 0) return;
  const haptics::SubWorld& sub_world = session.loop->sub_world();
  for (const BodyNumber member : hand.members)
    if (hand.roles[member] == Role::kMember) hand.roles[member] = Role::kGlobal;
  hand.members.clear();
  for (const physics::Body& body : sub_world.world().bodies()) {
    bodies[body.id] = to_state(session.scene, body.id, body.motion);
    hand.roles[body.id] = Role::kMember;
    hand.members.push_back(body.id);
  }
  const BodyNumber proxy = session.scene.proxy;
  bodies[proxy] = to_state(session.scene, proxy, sub_world.proxy());
  hand.roles[proxy] = Role::kMember;
  if (hand.members.empty()) hand.members.push_back(proxy);  // couplings in which the sub-world is the proxy alone
}

void StateView::list_contacts(const session::Session& session, Hand& hand) {
  hand.contacts.clear();
  const physics::World& world = session.loop->sub_world().world();
  const double per_s = 1.0 / session.options.period_s();
  for (const physics::Contact& contact : world.contacts()) {
    const physics::Body& a = world.bodies()[contact.slot_a];
    const BodyNumber b = contact.b_fixed ? world.fixed_bodies()[contact.slot_b].id : world.bodies()[contact.slot_b].id;
    const Vec3d centre = world.last_poses()[contact.slot_a].position;
    for (std::uint32_t i = 0; i < contact.count; ++i) {
      const physics::ContactPoint& point = contact.points[i];
      if (!(point.total_normal_impulse > 0 || point.separation <= 0)) continue;
      if (hand.contacts.size() == hand.contacts.capacity()) return;
      hand.contacts.push_back({.a = a.id,
                               .b = b,
                               .position_m = to_public(centre + point.from_a),
                               .normal = to_public(contact.normal),
                               .force_N = point.total_normal_impulse * per_s,
                               .friction_N = to_public(point.total_friction * per_s),
                               .separation_m = point.separation});
    }
  }
}

void StateView::list_border(const session::Session& session, Hand& hand) {
  hand.border.clear();
  const physics::World& world = session.loop->sub_world().world();
  const double per_s = 1.0 / session.options.period_s();
  for (const physics::BorderContact& contact : world.border_contacts()) {
    const physics::Body* inner = world.find(contact.member);
    if (inner == nullptr) continue;
    hand.roles[contact.member] = Role::kBorder;
    if (contact.outside < hand.roles.size() && hand.roles[contact.outside] == Role::kGlobal)
      hand.roles[contact.outside] = Role::kOutside;
    if (!(contact.step_normal_impulse > 0) || hand.border.size() == hand.border.capacity()) continue;
    const Posed& member = inner->motion.pose;
    hand.border.push_back({.member = contact.member,
                           .outside = contact.outside,
                           .position_m = to_public(contact.point_on(member)),
                           .normal = to_public(contact.normal),
                           .force_N = contact.step_normal_impulse * per_s,
                           .friction_N = to_public(contact.step_tangent_impulse * per_s)});
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
  for (std::size_t hand = 0; hand < view.hands.size(); ++hand) {
    std::ranges::copy(view_.hands[hand].roles, view.hands[hand].roles.begin());
    view.hands[hand].members.assign(view_.hands[hand].members.begin(), view_.hands[hand].members.end());
  }
  filled_.store(false, std::memory_order_release);
  return true;
}

}  // namespace tactus::library
