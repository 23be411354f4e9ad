// Fills the snapshot for a sub-world after a step: touches, members, joiners, the border.
#include <utility>

#include "rt/haptics/coupling/plane_coupling.h"
#include "rt/haptics/coupling/snapshot_bytes.h"
#include "rt/physics/collision/collide_parts.h"
#include "rt/physics/contact/find_contacts.h"
#include "sim/exchange/mesh_neighbourhood.h"
#include "sim/exchange/proxy_planes.h"
#include "sim/global_world.h"

namespace tactus::sim {

using haptics::WorldSnapshot;
using physics::Body;

void GlobalWorld::find_touches() noexcept {
  touches_.clear();
  for (auto contacts = std::as_const(world_).contacts(); !contacts.empty() && !contacts[0].b_fixed;) {
    const auto of_pair = physics::contacts_of_first_pair(contacts);
    if (physics::any_touching(of_pair)) touches_.push_back(contact_edge_of(of_pair, world_.bodies(), islands_.awake()));
    contacts = contacts.subspan(of_pair.size());
  }
  if (coupling_.border) add_approaching();
  add_joined();
  build_graph();
}

// Adds edges to bodies that a member will touch before the next choice of members has reached the sub-world.
void GlobalWorld::add_approaching() noexcept {
  for (const Device& device : devices_) add_approaching(device);
}

void GlobalWorld::add_approaching(const Device& device) noexcept {
  const auto awake = islands_.awake();
  const auto bodies = std::as_const(world_).bodies();
  // True if one body is a member of an earlier device's sub-world and the other is not: that device found this pair.
  const auto was_found = [&](const Approaching& pair) noexcept {
    return std::any_of(std::as_const(devices_).data(), &device, [&](const Device& before) noexcept {
      return before.extraction.is_member(awake[number_of(pair.a)]) !=
             before.extraction.is_member(awake[number_of(pair.b)]);
    });
  };
  const Approaching* last = nullptr;
  for (const Approaching& pair : approach_.find(world_, member_slots(device), approach_horizon_s())) {
    const bool same_pair = last != nullptr && last->a == pair.a && last->b == pair.b;
    last = &pair;
    // Other parts of the two bodies may have an edge already.
    const std::uint32_t a = number_of(pair.a), b = number_of(pair.b);
    const auto contacts = physics::find_contacts(world_.contacts(), bodies[a].id, bodies[b].id);
    if (same_pair || physics::any_touching(contacts) || was_found(pair)) continue;
    if (touches_.size() == touches_.capacity()) return;
    touches_.push_back({.a = awake[a],
                        .b = awake[b],
                        .point = bodies[a].motion.pose.position + pair.manifold.points[0].from_a,
                        .normal = pair.manifold.normal,
                        .joined = false});
  }
}

void GlobalWorld::add_joined() noexcept {
  const auto* joints = world_.effects().find<physics::Joints>();
  if (joints == nullptr) return;
  const auto awake = islands_.awake();
  const auto bodies = std::as_const(world_).bodies();
  joints->for_each_link(bodies, [&](std::uint32_t a, std::uint32_t b, std::uint32_t joint) noexcept {
    const Posed &at_a = bodies[a].motion.pose, &at_b = bodies[b].motion.pose;
    if (touches_.size() < touches_.capacity())
      touches_.push_back({.a = awake[a],
                          .b = awake[b],
                          .point = at_b * joints->joints()[joint].b_from_joint.position,
                          .normal = normalized_or(at_b.position - at_a.position, Vec3d{0, 0, 1}),
                          .joined = true});
  });
  const auto states = joints->states();
  statistics_.broken_joints = static_cast<std::uint32_t>(
      std::count_if(states.begin(), states.end(), [](const auto& s) { return s.broken != 0; }));
}

// Before the first step there are no contact impulses: bodies within touch_tolerance_m count as touching.
void GlobalWorld::find_touches_at_rest() noexcept {
  const std::span<const Body> bodies = world_.bodies();
  const auto awake = islands_.awake();
  for (std::size_t slot = 0; slot < bodies.size(); ++slot)
    bounds_[slot] = physics::bounds_of(bodies[slot].shape, bodies[slot].motion.pose, options_.touch_tolerance_m);
  auto& pairs = world_.dynamic_pairs();
  pairs.clear();
  if (!pair_cache_.find(std::span(std::as_const(bounds_)).first(bodies.size()), pairs))
    statistics_.capacity_bits |= physics::kPairsFull;
  std::sort(pairs.begin(), pairs.end(), [](const physics::SlotPair& p, const physics::SlotPair& q) {
    const auto low = [](const physics::SlotPair& x) { return std::min(x.a, x.b); };
    const auto high = [](const physics::SlotPair& x) { return std::max(x.a, x.b); };
    return low(p) != low(q) ? low(p) < low(q) : high(p) < high(q);
  });
  touches_.clear();
  for (const auto& pair : pairs) {
    const std::uint32_t a = std::min(pair.a, pair.b), b = std::max(pair.a, pair.b);
    Vec3d from_a, normal;
    std::uint32_t points = 0;
    physics::for_each_manifold(posed_shape(bodies[a]), posed_shape(bodies[b]), options_.touch_tolerance_m,
                               world_.shapes(), [&](std::uint32_t, std::uint32_t, const auto& manifold) noexcept {
                                 if (points == 0) normal = manifold.normal;
                                 points += manifold.count;
                                 for (std::uint32_t i = 0; i < manifold.count; ++i) from_a += manifold.points[i].from_a;
                               });
    if (points == 0 || touches_.size() == touches_.capacity()) continue;
    touches_.push_back({.a = awake[a],
                        .b = awake[b],
                        .point = bodies[a].motion.pose.position + from_a * (1.0 / points),
                        .normal = normal,
                        .joined = false});
  }
  pairs.clear();
  add_joined();
  build_graph();
}

void GlobalWorld::fill_snapshot(std::uint32_t device, std::uint64_t cycle, std::uint32_t budget,
                                WorldSnapshot& next) noexcept {
  choose_members(device, cycle, budget, next);
  if (!predicts()) return;
  predictions_[device]->fill_corrections(world_, next);
  predictions_[device]->adopt(next);
}

// Kinetic energy of the bodies that contacts and joints link to members.
double GlobalWorld::outside_motion_J(const Device& device) noexcept {
  graph_.find_component(device.proxy, device.extraction.members());
  double sum_J = 0;
  for (const BodyIndex body : graph_.visited())
    if (!device.extraction.is_member(body)) sum_J += kinetic_energy(islands_.bodies()[body]);
  return sum_J;
}

// Chooses the members and fills everything but the corrections.
void GlobalWorld::choose_members(std::uint32_t device_index, std::uint64_t cycle, std::uint32_t budget,
                                 WorldSnapshot& next) noexcept {
  Device& device = devices_[device_index];
  find_free_bodies(device);
  if (coupling_.proxy_alone()) budget = 1;
  const auto bodies = islands_.bodies();
  const auto members = device.extraction.choose(bodies, graph_, device.reported_proxy, budget, free_, islands_.awake());
  device.component.assign(graph_.visited().begin(), graph_.visited().end());

  next.cycle = cycle;
  next.global_time_s = time_s_;
  next.epoch = epoch();
  next.component = device.extraction.statistics().component;
  next.border_work_J = 0;
  next.outside_motion_J = border_.has_tank ? outside_motion_J(device) : 0;
  next.dropped = 0;
  next.proxy = bodies[device.proxy].motion;
  next.members.clear();
  for (const BodyIndex member : members) TACTUS_CHECK(next.members.try_push(bodies[member].id), number_of(member), 0);
  next.corrections.clear();
  next.border.clear();
  next.outside.clear();
  next.warm_starts.clear();
  next.effects.clear();
  fill_joiners(device, next);
  fill_near_triangles({.bodies = bodies, .members = members, .proxy = device.proxy}, world_.fixed_bodies(),
                      world_.shapes().meshes, device.reach, next);
  if (coupling_.border) {
    if (!haptics::write_effects(world_, member_slots(device), next.effects)) ++next.dropped;
    if (stepped_) fill_border(device, next);
    SubWorldPrediction* const prediction = predicts() ? predictions_[device_index].get() : nullptr;
    if (prediction != nullptr) prediction->find_corrected(next);
    fill_warm_starts(device, prediction, next);
  }
  if (coupling_.proxy_planes > 0 && stepped_)
    fill_proxy_planes(world_, device.id, macro_step_s_, coupling_.proxy_planes, next.border);
  device.has_border = next.has_border();
  count(device, next);
}

// Fills the border from the last macro step.
void GlobalWorld::fill_border(const Device& device, WorldSnapshot& next) noexcept {
  next.border_work_J = device.border_work_J;
  const auto members = member_slots(device);
  const StepContacts step{.contacts = world_.contacts(),
                          .bodies = std::as_const(world_).bodies(),
                          .start = world_.last_poses(),
                          .step_s = macro_step_s_};
  next.dropped += border_exchange_.fill(step, members, border_.ghosts, next.border);
  if (!border_.ghosts) return;
  next.dropped += border_exchange_.add_approaching(approach_.find(world_, members, approach_horizon_s()), step, members,
                                                   next.border);
  next.dropped += border_exchange_.fill_outside(world_, members, {macro_step_s_, sub_step_s(), settings_.dt},
                                                next.border.span(), next.outside);
}

// Copies whole bodies, bit by bit. Frozen members (static coupling) are sent every time, except the proxy, whose state
// the sub-world keeps.
void GlobalWorld::fill_joiners(const Device& device, WorldSnapshot& next) noexcept {
  next.joiners.clear();
  const bool renew = coupling_.members_frozen;
  for (const BodyIndex member : device.extraction.members())
    if (device.extraction.is_joiner(member) || (renew && member != device.proxy))
      TACTUS_CHECK(next.joiners.try_push(islands_.bodies()[member]), number_of(member), 0);
}

// Sends the impulses of contacts among members and with static geometry that the sub-world continues: those of joiners,
// then those of members that the prediction corrects (border_correction.h), which have impulses of their own if these
// do not fit.
void GlobalWorld::fill_warm_starts(const Device& device, const SubWorldPrediction* prediction,
                                   WorldSnapshot& next) noexcept {
  const auto& e = device.extraction;
  const auto awake = islands_.awake();
  for (const bool of_joiners : {true, false}) {
    if (!of_joiners && prediction == nullptr) return;
    for (const auto& contact : world_.contacts()) {
      const BodyIndex a = awake[contact.slot_a], b = contact.b_fixed ? a : awake[contact.slot_b];
      if (!e.is_member(a) || !e.is_member(b) || of_joiners != (e.is_joiner(a) || e.is_joiner(b))) continue;
      const auto is_corrected = [&](BodyIndex body) { return prediction->corrects(islands_.bodies()[body].id); };
      if (!of_joiners && !is_corrected(a) && !is_corrected(b)) continue;
      if (!next.warm_starts.try_push(physics::World::warm_start_of(contact, sub_step_s()))) ++next.dropped;
    }
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
