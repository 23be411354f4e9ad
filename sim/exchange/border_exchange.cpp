#include "sim/exchange/border_exchange.h"

#include "rt/base/rotation_vector.h"
#include "rt/physics/contact/find_contacts.h"
#include "rt/physics/contact/pair_friction.h"
#include "rt/physics/push_out.h"

namespace tactus::sim {
namespace {

using haptics::BorderPoint;
using haptics::BorderReturn;
using haptics::OutsideBody;
using physics::Body;
using physics::Contact;

// The body's share of a contact's inverse effective mass, along n at r from its centre.
double own_inverse_mass(const Body& body, const Quatd& rotation, const Vec3d& r, const Vec3d& n) noexcept {
  const Vec3d turn = rotate_inverse(rotation, cross(r, n));
  return 1 / body.mass + turn.x * turn.x / body.inertia.x + turn.y * turn.y / body.inertia.y +
         turn.z * turn.z / body.inertia.z;
}

// About the body's centre.
void give(physics::SlotIndex slot, const Wrenchd& impulse, physics::World& world, ImpulseReturn& result) noexcept {
  const Body& body = world.body(slot);
  const double before = kinetic_energy(body);
  world.apply_impulse(slot, impulse);
  result.impulse_Ns += impulse.force;
  result.magnitude_Ns += norm(impulse.force);
  result.energy_J += kinetic_energy(body) - before;
}

void give(physics::SlotIndex slot, const Vec3d& impulse, const Vec3d& point, physics::World& world,
          ImpulseReturn& result) noexcept {
  give(slot, {impulse, cross(point - world.body(slot).motion.pose.position, impulse)}, world, result);
}

// Reverses the friction impulses that the global step applied to the outside body at this pair.
void take_back(const Contact& contact, physics::SlotIndex outside, physics::World& world,
               ImpulseReturn& result) noexcept {
  const Body& body = world.body(outside);
  const bool outside_is_b = contact.slot_b == number_of(outside);
  for (std::uint32_t i = 0; i < contact.count; ++i) {
    const auto& point = contact.points[i];
    const Vec3d on_outside = outside_is_b ? point.total_friction : -point.total_friction;
    const Vec3d arm = outside_is_b ? point.from_b : point.from_a;
    give(outside, -on_outside, body.motion.pose.position + arm, world, result);
  }
}

// A smooth acceleration over the step is extrapolated: the body slides to rest, swings or is pushed. If the velocity
// would change by more than this fraction in a cycle, it fluctuates within the step or the body had an impact, and
// nothing is extrapolated. Measured range: from 0.25 to 1 only the errors of impacts change (tests/border/README.md).
constexpr double kEven = 0.5;

// Growth of the members' force on an outside body from step to step up to which the force counts as lasting. Measured
// range: 1.25 to 3 (tests/border/README.md).
constexpr double kGrowth = 2;

// Rate of a velocity expected over the next cycle, of its value at the end of the step and its mean over it; a
// deceleration at most stops the motion within that cycle. `late_s`: from mid-step, where the mean is reached, to the
// end.
Vec3d rate_to_come(const Vec3d& end, const Vec3d& mean, double late_s, double cycle_s) noexcept {
  const Vec3d rate = (end - mean) * (1 / late_s);
  const double change = cycle_s * norm(rate), speed = norm(end);
  if (!(change > 0) || !(change <= kEven * std::max(speed, norm(end - cycle_s * rate)))) return {};
  return rate * (dot(rate, end) < 0 ? std::min(1.0, speed / change) : 1.0);
}

// Acceleration of the body expected over the next cycle [m/s^2, rad/s^2].
Twistd acceleration_to_come(const Body& body, const Posed& start, const StepTimes& times) noexcept {
  const double late_s = 0.5 * (times.step_s - times.sub_step_s);
  if (!(late_s > 0)) return {};
  const auto& [pose, end] = body.motion;
  const Vec3d moved = pose.position - start.position;
  const Vec3d turned = rotation_vector_of(pose.rotation * conjugate(start.rotation));
  return {rate_to_come(end.linear, moved * (1 / times.step_s), late_s, times.cycle_s),
          rate_to_come(end.angular, turned * (1 / times.step_s), late_s, times.cycle_s)};
}

// A joint between a member and an outside body, after a step.
struct JointAcross {
  physics::SlotIndex member, outside;
  Vec3d point;        // m, world: origin of the joint frame on B, after the step
  Wrenchd on_member;  // N, N m, at `point`: mean over the step
};

template <class F>
void for_each_joint_across(const physics::World& world, std::span<const std::uint8_t> members, F&& f) noexcept {
  const auto* joints = world.effects().find<physics::Joints>();
  if (joints == nullptr) return;
  const auto bodies = world.bodies();
  joints->for_each_link(bodies, [&](std::uint32_t a, std::uint32_t b, std::uint32_t joint) noexcept {
    if (members[a] == members[b]) return;
    const auto& state = joints->states()[joint];
    const Vec3d point = bodies[b].motion.pose * joints->joints()[joint].b_from_joint.position;
    const physics::SlotIndex slot_a{a}, slot_b{b};
    if (members[b] != 0)
      f(JointAcross{.member = slot_b, .outside = slot_a, .point = point, .on_member = {state.force, state.torque}});
    else
      f(JointAcross{.member = slot_a, .outside = slot_b, .point = point, .on_member = {-state.force, -state.torque}});
  });
}

}  // namespace

BorderPoint border_point(const Contact& contact, const physics::ContactPoint& point, bool member_is_a,
                         const BodyOverStep& member, const BodyOverStep& outside, double step_s) noexcept {
  BorderPoint result;
  result.member = member.body.id;
  result.outside = outside.body.id;
  result.feature = point.feature;
  result.parts = contact.key.parts();
  result.normal = member_is_a ? -contact.normal : contact.normal;
  result.member_round_m = member_is_a ? contact.round_a : contact.round_b;
  result.outside_round_m = member_is_a ? contact.round_b : contact.round_a;
  // The lever arms date from the start of the step, so they are rotated into the body with its pose at the start.
  const Vec3d to_centre = result.outside_round_m * result.normal;
  result.member_anchor = rotate_inverse(
      member.start.rotation, (member_is_a ? point.from_a : point.from_b) + result.member_round_m * result.normal);
  const Vec3d anchor = rotate_inverse(outside.start.rotation, (member_is_a ? point.from_b : point.from_a) - to_centre);
  result.impulse_rate_N = point.total_normal_impulse / step_s;
  result.friction = contact.friction;
  result.outside_point = outside.body.motion.pose * anchor + to_centre;
  result.separation_m = point.separation;
  // The mean over the step, not the velocity at its end: the velocity of a constrained body fluctuates within a step,
  // and a member that followed its value at one instant for a whole cycle would be thrown.
  result.outside_velocity = (outside.body.motion.pose * anchor - outside.start * anchor) * (1.0 / step_s);
  if (result.outside_round_m > 0.0) {
    const Quatd turned = outside.body.motion.pose.rotation * conjugate(outside.start.rotation);
    result.outside_velocity += cross(rotation_vector_of(turned) * (1.0 / step_s), to_centre);
  }
  return result;
}

double border_work_J(const physics::World& world, std::span<const Twistd> before, std::span<const std::uint8_t> members,
                     double step_s) noexcept {
  const auto contacts = world.contacts();
  const auto bodies = world.bodies();
  double work_J = 0;
  for_each_joint_across(world, members, [&](const JointAcross& joint) noexcept {
    const auto& [pose, now] = world.body(joint.member).motion;
    const Twistd& then = before[number_of(joint.member)];
    const Vec3d v = 0.5 * (then.linear + now.linear);
    const Vec3d w = 0.5 * (then.angular + now.angular);
    const Vec3d r = joint.point - pose.position;
    work_J += step_s * (dot(joint.on_member.force, v + cross(w, r)) + dot(joint.on_member.torque, w));
  });
  for (const auto& contact : contacts) {
    if (contact.b_fixed || members[contact.slot_a] == members[contact.slot_b]) continue;
    const bool a = members[contact.slot_a] != 0;
    const std::uint32_t member = a ? contact.slot_a : contact.slot_b;
    const Twistd& now = bodies[member].motion.velocity;
    const Vec3d v = 0.5 * (before[member].linear + now.linear), w = 0.5 * (before[member].angular + now.angular);
    for (std::uint32_t i = 0; i < contact.count; ++i) {
      const auto& point = contact.points[i];
      const Vec3d on_b = point.total_normal_impulse * contact.normal + point.total_friction;
      work_J += (a ? -1 : 1) * dot(on_b, v + cross(w, a ? point.from_a : point.from_b));
    }
  }
  return work_J;
}

double push_out_J(const physics::World& world, std::span<const Twistd> before, std::span<const std::uint8_t> members,
                  double step_s, const Vec3d& gravity, const physics::PoseSpring& spring) noexcept {
  const auto bodies = world.bodies();
  const auto moved = [&](std::uint32_t slot) noexcept {
    const Posed &start = world.last_poses()[slot], &end = bodies[slot].motion.pose;
    return Twistd{end.position - start.position, small_rotation_vector(end.rotation * conjugate(start.rotation))};
  };
  const auto path = [&](std::uint32_t slot) noexcept {
    return (before[slot] + bodies[slot].motion.velocity) * (0.5 * step_s);
  };
  double work_J = 0;
  for (std::uint32_t i = 0; i < bodies.size(); ++i)
    if (members[i] != 0) work_J += physics::push_out_J(bodies[i], gravity, moved(i).linear, path(i).linear);
  if (!spring.enabled) return work_J;
  const std::uint32_t slot = number_of(spring.slot);
  return work_J + physics::push_out_J(spring.step_impulse * (1.0 / step_s), moved(slot), path(slot));
}

BorderExchange::BorderExchange(std::uint32_t max_bodies, std::uint32_t max_contacts, std::uint32_t max_joints,
                               double added_inertia)
    : added_inertia_(added_inertia), admittance_(max_bodies, max_contacts, max_joints) {
  points_.reserve(std::size_t{max_contacts} * physics::kMaxManifoldPoints);
  loads_.reserve(std::size_t{haptics::kMaxBorderPoints} + max_joints);
  order_.reserve(points_.capacity());
  force_now_.reserve(physics::kMaxSprings * loads_.capacity());
  force_before_.reserve(force_now_.capacity());
}

void BorderExchange::begin_step() noexcept {
  force_before_.swap(force_now_);
  force_now_.clear();
  std::sort(force_before_.begin(), force_before_.end(),
            [](const ForceOn& p, const ForceOn& q) { return p.outside < q.outside; });
}

std::uint32_t BorderExchange::fill(const StepContacts& step, std::span<const std::uint8_t> members, bool near_points,
                                   FixedVector<BorderPoint, haptics::kMaxBorderPoints>& border) noexcept {
  const auto& [contacts, bodies, start, step_s] = step;
  border.clear();
  points_.clear();
  for (const auto& contact : contacts) {
    if (contact.b_fixed || members[contact.slot_a] == members[contact.slot_b]) continue;
    const bool a = members[contact.slot_a] != 0;
    const std::uint32_t member = a ? contact.slot_a : contact.slot_b, outside = a ? contact.slot_b : contact.slot_a;
    for (std::uint32_t i = 0; i < contact.count; ++i) {
      const auto& point = contact.points[i];
      if (point.redundant) continue;
      if (!near_points && point.total_normal_impulse <= 0 && point.separation > 0) continue;
      points_.push_back(
          border_point(contact, point, a, {bodies[member], start[member]}, {bodies[outside], start[outside]}, step_s));
      points_.back().friction_N = (a ? -1 / step_s : 1 / step_s) * point.total_friction;
      points_.back().outside_inverse_mass =
          own_inverse_mass(bodies[outside], start[outside].rotation, a ? point.from_b : point.from_a, contact.normal);
    }
  }
  const auto fits = std::min<std::size_t>(points_.size(), haptics::kMaxBorderPoints);
  order_.clear();
  for (std::uint32_t i = 0; i < points_.size(); ++i) order_.push_back(i);
  if (fits < points_.size()) {
    std::sort(order_.begin(), order_.end(), [&](std::uint32_t i, std::uint32_t j) {
      return points_[i].impulse_rate_N != points_[j].impulse_rate_N
                 ? points_[i].impulse_rate_N > points_[j].impulse_rate_N
                 : i < j;
    });
    std::sort(order_.begin(), order_.begin() + static_cast<std::ptrdiff_t>(fits));
  }
  for (std::size_t i = 0; i < fits; ++i) (void)border.try_push(points_[order_[i]]);
  return static_cast<std::uint32_t>(points_.size() - fits);
}

std::uint32_t BorderExchange::add_approaching(std::span<const Approaching> pairs, const StepContacts& step,
                                              std::span<const std::uint8_t> members,
                                              FixedVector<BorderPoint, haptics::kMaxBorderPoints>& border) noexcept {
  const auto& bodies = step.bodies;
  std::uint32_t left_out = 0;
  for (const Approaching& pair : pairs) {
    const Body &body_a = bodies[number_of(pair.a)], &body_b = bodies[number_of(pair.b)];
    const PairKey key = PairKey::of(BodyPart{body_a.id, pair.part_a}, BodyPart{body_b.id, pair.part_b}, false);
    if (physics::find_contact(step.contacts, key) != nullptr) continue;
    const bool a = members[number_of(pair.a)] != 0;
    const Body &member = a ? body_a : body_b, &outside = a ? body_b : body_a;
    for (std::uint32_t i = 0; i < pair.manifold.count; ++i) {
      const auto& found = pair.manifold.points[i];
      const Vec3d &on_member = a ? found.from_a : found.from_b, &on_outside = a ? found.from_b : found.from_a;
      BorderPoint point;
      point.member = member.id;
      point.outside = outside.id;
      point.feature = found.feature;
      point.parts = key.parts();
      point.normal = a ? -pair.manifold.normal : pair.manifold.normal;
      point.member_round_m = a ? pair.round_a : pair.round_b;
      point.outside_round_m = a ? pair.round_b : pair.round_a;
      point.member_anchor =
          rotate_inverse(member.motion.pose.rotation, on_member + point.member_round_m * point.normal);
      point.friction = physics::pair_friction(member, outside);
      point.outside_point = outside.motion.pose.position + on_outside;
      point.separation_m = found.separation;
      point.outside_inverse_mass =
          own_inverse_mass(outside, outside.motion.pose.rotation, on_outside, pair.manifold.normal);
      if (!border.try_push(point)) ++left_out;
    }
  }
  return left_out;
}

std::uint32_t BorderExchange::fill_outside(const physics::World& world, std::span<const std::uint8_t> members,
                                           const StepTimes& times, std::span<const BorderPoint> border,
                                           FixedVector<OutsideBody, haptics::kMaxOutsideBodies>& outside) noexcept {
  outside.clear();
  collect_loads(world, members, border);
  if (loads_.empty()) return 0;
  admittance_.index(world, added_inertia_, times.step_s);
  std::uint32_t left_out = 0;
  for (std::size_t i = 0; i < loads_.size();) {
    const BodyId id = loads_[i].outside;
    const physics::SlotIndex slot = *world.slot_of(id);
    const Body& found = world.body(slot);
    OutsideBody body;
    body.id = id;
    body.centre = found.motion.pose.position;
    const OutsideAnswer answer = admittance_.find(slot, members);
    body.velocity = answer.velocity;
    Wrenchd load;
    bool touched = false;
    for (; i < loads_.size() && loads_[i].outside == id; ++i) {
      touched = touched || loads_[i].touches;
      load += Wrenchd{loads_[i].force, loads_[i].torque + cross(loads_[i].point - body.centre, loads_[i].force)};
    }
    body.admittance = touched ? answer.admittance : admittance_.free_admittance(slot);
    const Twistd under_load = body.admittance * (lasting_share(id, load) * load);
    body.drive = acceleration_to_come(found, world.last_poses()[number_of(slot)], times) - under_load;
    if (!outside.try_push(body)) ++left_out;
  }
  return left_out;
}

// A body that was not at the border after the step before may have been loaded then: all of its load counts.
double BorderExchange::lasting_share(BodyId outside, const Wrenchd& load) noexcept {
  const double now = norm(load.force);
  force_now_.push_back({outside, now});
  const auto before = std::lower_bound(force_before_.begin(), force_before_.end(), outside,
                                       [](const ForceOn& force, BodyId body) { return force.outside < body; });
  if (before == force_before_.end() || before->outside != outside) return 1;
  return now > kGrowth * before->force_N ? kGrowth * before->force_N / now : 1;
}

// Sorted by outside body.
void BorderExchange::collect_loads(const physics::World& world, std::span<const std::uint8_t> members,
                                   std::span<const BorderPoint> border) noexcept {
  loads_.clear();
  for (const BorderPoint& point : border)
    loads_.push_back({.outside = point.outside,
                      .touches = point.impulse_rate_N > 0 || point.separation_m <= 0,
                      .force = -(point.impulse_rate_N * point.normal + point.friction_N),
                      .point = point.outside_point,
                      .torque = {}});
  for_each_joint_across(world, members, [&](const JointAcross& joint) noexcept {
    loads_.push_back({.outside = world.body(joint.outside).id,
                      .touches = true,
                      .force = -joint.on_member.force,
                      .point = joint.point,
                      .torque = -joint.on_member.torque});
  });
  std::sort(loads_.begin(), loads_.end(), [](const Load& p, const Load& q) { return p.outside < q.outside; });
}

ImpulseReturn return_impulses(std::span<const BorderReturn> returns, std::span<const std::uint8_t> members,
                              physics::BorderTraits::Return returned, physics::World& world) noexcept {
  using Return = physics::BorderTraits::Return;
  ImpulseReturn result;
  if (returned == Return::kNothing) return result;
  for (std::size_t i = 0; i < returns.size(); ++i) {
    const BorderReturn& entry = returns[i];
    const std::optional<physics::SlotIndex> outside = world.slot_of(entry.outside);
    if (!outside || !is_finite(entry.tangent_impulse) || !is_finite(entry.point)) continue;
    if (members[number_of(*outside)] != 0) {
      ++result.skipped;
      continue;
    }
    // Once for every pair: the entries of a pair are consecutive.
    const bool first_of_pair =
        i == 0 || returns[i - 1].member != entry.member || returns[i - 1].outside != entry.outside;
    if (returned == Return::kChange && first_of_pair) {
      for (const Contact& contact : physics::find_contacts(world.contacts(), entry.member, entry.outside))
        take_back(contact, *outside, world, result);
    }
    give(*outside, -entry.tangent_impulse, entry.point, world, result);
  }
  return result;
}

ImpulseReturn return_impulses(std::span<const haptics::OutsideImpulse> impulses, physics::World& world) noexcept {
  ImpulseReturn result;
  for (const haptics::OutsideImpulse& given : impulses)
    if (const std::optional<physics::SlotIndex> slot = world.slot_of(given.id))
      give(*slot, given.impulse, world, result);
  return result;
}

}  // namespace tactus::sim
