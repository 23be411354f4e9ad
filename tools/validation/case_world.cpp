#include "tools/validation/case_world.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "rt/base/check.h"
#include "rt/base/denormals.h"
#include "rt/physics/contact/softness.h"
#include "tools/experiment/allocation_count.h"

namespace tactus::hard_cases {
namespace {

constexpr double kMaxGain = 1e-3;  // of the largest energy in play

double inverse_mass_at(const physics::Body& body, const Vec3d& arm, const Vec3d& n) {
  const Vec3d turned = rotate_inverse(body.motion.pose.rotation, cross(arm, n));
  return 1 / body.mass + turned.x * turned.x / body.inertia.x + turned.y * turned.y / body.inertia.y +
         turned.z * turned.z / body.inertia.z;
}

}  // namespace

physics::StepSettings settings_of(const Setting& setting, double contact_hertz) {
  physics::StepSettings settings;
  settings.dt = setting.step_s;
  settings.sub_steps = sub_steps_of(setting);
  const double h = settings.dt / settings.sub_steps;
  settings.contact_hertz = std::min(contact_hertz, 0.25 / h);
  settings.relax_sweeps = std::max(physics::least_relax_sweeps(settings.contact_hertz, h),
                                   setting.accuracy == Accuracy::kAccurate ? 2u : 1u);
  settings.gravity = {0, 0, -kGravity};
  return settings;
}

CaseWorld::CaseWorld(const Setting& setting, double contact_hertz, const physics::Capacities& capacities,
                     const physics::ShapeLists& shapes, const physics::EffectSetups& effects)
    : world(capacities, shapes, effects), settings(settings_of(setting, contact_hertz)) {
  set_denormals_flush();
}

int CaseWorld::steps_in(double seconds) const { return static_cast<int>(std::lround(seconds / settings.dt)); }

void CaseWorld::run(double seconds) {
  for (int i = steps_in(seconds); i > 0; --i) step();
}

// Same sequence as a step of the global world.
void CaseWorld::step() {
  const bool whole = world.device_spring().enabled || !world.border_contacts().empty();
  const std::uint32_t macro_steps = whole ? 1 : physics::macro_steps_of(world, settings);
  for (std::uint32_t k = 0; k < macro_steps; ++k)
    take_macro_step(physics::settings_of_macro_step(settings, macro_steps));
}

void CaseWorld::take_macro_step(const physics::StepSettings& macro_step) {
  const double before_J = stored_J(0);
  for (const Held& held : held_) world.apply_wrench(slot(held.id), held.wrench);
  const std::uint64_t allocations = experiment::allocation_count();
  world.begin_step(macro_step);
  if (!find_pairs_brute_force(world.bounds(), world.dynamic_pairs())) lost_ |= physics::kPairsFull;
  report = world.finish_step(macro_step, cut);
  allocations_ += experiment::allocation_count() - allocations;
  lost_ |= report.capacity_bits;
  macro_step_s_ = macro_step.dt;
  add_to_balance(stored_J(macro_step.dt) - before_J - work_of_step_J());
}

// Kinetic and potential energy, and the energy of the device's spring with its target extrapolated by `ahead_s`.
double CaseWorld::stored_J(double ahead_s) {
  const double energy = world.kinetic_energy() + world.potential_energy(settings.gravity);
  const auto& spring = world.device_spring();
  if (!spring.enabled) return energy;
  const Posed& pose = world.body(spring.slot).motion.pose;
  const Vec3d stretch = pose.position - spring.target.position - ahead_s * spring.target_velocity.linear;
  const Quatd target = quat_from_rotation_vector(ahead_s * spring.target_velocity.angular) * spring.target.rotation;
  const Quatd turn = pose.rotation * conjugate(target);
  // The torque at an angle a is 2 K sin(a / 2), so the stored energy is 4 K (1 - cos(a / 2)).
  return energy + 0.5 * spring.stiffness_N_per_m * norm_squared(stretch) +
         spring.stiffness_Nm_per_rad * norm_squared(small_rotation_vector(turn)) / (1 + std::abs(turn.w));
}

// Work of the held wrenches along the bodies' motion, plus the work of the device's target against the spring force.
double CaseWorld::work_of_step_J() {
  double work = 0;
  for (const Held& held : held_) {
    const Posed &start = world.last_poses()[number_of(slot(held.id))], &end = body(held.id).motion.pose;
    work += dot(held.wrench.force, end.position - start.position) +
            dot(held.wrench.torque, small_rotation_vector(end.rotation * conjugate(start.rotation)));
  }
  const auto& spring = world.device_spring();
  if (spring.enabled)
    work += dot(spring.step_impulse.force, spring.target_velocity.linear) +
            dot(spring.step_impulse.torque, spring.target_velocity.angular);
  return work;
}

void CaseWorld::add_to_balance(double gained_J) {
  const Springs springs = springs_J();
  double fall = 0;
  for (const auto& body : world.bodies()) {
    finite_ = finite_ && is_finite(body.motion.pose) && is_finite(body.motion.velocity);
    fall += body.mass * norm(settings.gravity) * bounding_radius(body.shape);
  }
  for (const Held& held : held_) fall += norm(held.wrench.force) * bounding_radius(body(held.id).shape);
  largest_J_ = std::max(largest_J_, world.kinetic_energy() + springs.before + fall);
  unexplained_J_ += gained_J - std::max(0.0, springs.before - springs.after);
  least_J_ = std::min(least_J_, unexplained_J_);
  gain_J_ = std::max(gain_J_, unexplained_J_ - least_J_);
}

// Energy of the contact springs, for the points found at the start of the step: at the start and at the end of the
// step.
CaseWorld::Springs CaseWorld::springs_J() const {
  const double omega = 2 * kPi * settings.contact_hertz;
  Springs springs;
  for (const auto& contact : world.contacts()) {
    const auto moved = [&](std::uint32_t slot, const Vec3d& arm) {
      const Posed &start = world.last_poses()[slot], &end = world.bodies()[slot].motion.pose;
      return end.position - start.position + rotate(end.rotation * conjugate(start.rotation), arm) - arm;
    };
    for (std::uint32_t i = 0; i < contact.count; ++i) {
      const auto& point = contact.points[i];
      double inverse = inverse_mass_at(world.bodies()[contact.slot_a], point.from_a, contact.normal);
      double gap = point.separation + settings.slop, change = -dot(contact.normal, moved(contact.slot_a, point.from_a));
      if (!contact.b_fixed) {
        inverse += inverse_mass_at(world.bodies()[contact.slot_b], point.from_b, contact.normal);
        change += dot(contact.normal, moved(contact.slot_b, point.from_b));
      }
      const double stiffness = omega * omega / inverse, before = std::min(0.0, gap),
                   after = std::min(0.0, gap + change);
      springs.before += 0.5 * stiffness * before * before;
      springs.after += 0.5 * stiffness * after * after;
    }
  }
  return springs;
}

void CaseWorld::hold(BodyId id, const Wrenchd& wrench) {
  std::erase_if(held_, [id](const Held& held) { return held.id == id; });
  if (wrench != Wrenchd{}) held_.push_back({id, wrench});
}

void CaseWorld::close(Outcome& outcome) const {
  outcome.hash = world.state_hash();
  outcome.gate("finite", finite_);
  outcome.gate(fmt::format("energy: {:.2g} J from nowhere, of {:.2g} J", gain_J_, largest_J_),
               !energy_is_checked || gain_J_ <= kMaxGain * largest_J_);
  outcome.gate("no allocation", allocations_ == 0);
  outcome.gate("nothing left out", lost_ == 0);
}

double CaseWorld::fastest() const {
  double speed = 0;
  for (const auto& body : world.bodies()) speed = std::max(speed, norm(body.motion.velocity.linear));
  return speed;
}

void CaseWorld::add(const physics::Body& body) { TACTUS_CHECK(world.insert(body), body.id, world.bodies().size()); }

void CaseWorld::add_ground(BodyId id, double friction, double slope_rad) {
  const Quatd tilt = quat_from_rotation_vector(Vec3d{0, slope_rad, 0});
  add(physics::make_fixed_body(id, physics::Shape::plane(), friction, {{}, tilt}));
}

void CaseWorld::add_box(BodyId id, const Vec3d& half, double mass, double friction, const Posed& pose,
                        const Twistd& twist) {
  auto made = physics::make_dynamic_body(id, physics::Shape::box(half), mass, friction, pose);
  made.motion.velocity = twist;
  add(made);
}

void CaseWorld::add_sphere(BodyId id, double radius, double mass, double friction, const Vec3d& at,
                           const Vec3d& velocity) {
  auto made = physics::make_dynamic_body(id, physics::Shape::sphere(radius), mass, friction, {at, {}});
  made.motion.velocity.linear = velocity;
  add(made);
}

double CaseWorld::carried_by_fixed() const {
  double impulse = 0;
  for (const auto& contact : world.contacts())
    for (std::uint32_t i = 0; contact.b_fixed && i < contact.count; ++i)
      impulse += contact.points[i].total_normal_impulse;
  return impulse / macro_step_s_;
}

double CaseWorld::carried_between(BodyId a, BodyId b) const {
  double impulse = 0;
  for (const auto& contact : world.contacts()) {
    const auto others = contact.b_fixed ? world.fixed_bodies() : std::span<const physics::Body>(world.bodies());
    const BodyId first = world.bodies()[contact.slot_a].id, second = others[contact.slot_b].id;
    if (std::min(first, second) != std::min(a, b) || std::max(first, second) != std::max(a, b)) continue;
    for (std::uint32_t i = 0; i < contact.count; ++i) impulse += contact.points[i].total_normal_impulse;
  }
  return impulse / macro_step_s_;
}

double CaseWorld::overlap_under(double load_N, double mass_kg) const {
  const double omega = 2 * kPi * settings.contact_hertz;
  return settings.slop + load_N / (mass_kg * omega * omega);
}

// A corner is off a cube's centre by half an edge in both directions: 1/m + 2 half^2 / (m (2 half)^2 / 6) = 4/m.
double face_mass(double mass, double other, const Vec3d& half) {
  // A corner's r x n against the box's inertia m (a^2 + c^2) / 3: 3 / m in all for a cube, 6 / m for a thin card.
  const double at_corner =
      1 + 3 / (1 + half.z * half.z / (half.x * half.x)) + 3 / (1 + half.z * half.z / (half.y * half.y));
  return 4 / at_corner / (1 / mass + (other > 0 ? 1 / other : 0));
}

double tilt_of(const Quatd& rotation) {
  const Vec3d up = rotate(rotation, Vec3d{0, 0, 1});
  return std::atan2(std::hypot(up.x, up.y), up.z);
}

}  // namespace tactus::hard_cases
