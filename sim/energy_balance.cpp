#include "sim/energy_balance.h"

#include <numbers>

#include "sim/model/scene.h"

namespace tactus::sim {
namespace {

double inverse_mass_at(const physics::Body& body, const Vec3d& arm, const Vec3d& n) noexcept {
  const Vec3d turned = rotate_inverse(body.motion.pose.rotation, cross(arm, n));
  return 1 / body.mass + turned.x * turned.x / body.inertia.x + turned.y * turned.y / body.inertia.y +
         turned.z * turned.z / body.inertia.z;
}

double contact_springs_J(const physics::World& world, double contact_hertz, double slop_m) noexcept {
  const double omega = 2 * std::numbers::pi * contact_hertz;
  const auto moved = [&world](std::uint32_t slot, const Vec3d& arm) {
    const Posed &start = world.last_poses()[slot], &now = world.bodies()[slot].motion.pose;
    return now.position - start.position + rotate(now.rotation * conjugate(start.rotation), arm) - arm;
  };
  double sum_J = 0;
  for (const auto& contact : world.contacts())
    for (std::uint32_t i = 0; i < contact.count; ++i) {
      const auto& point = contact.points[i];
      double gap_m = point.separation + slop_m - dot(contact.normal, moved(contact.slot_a, point.from_a));
      if (!contact.b_fixed) gap_m += dot(contact.normal, moved(contact.slot_b, point.from_b));
      if (!(gap_m < 0)) continue;  // also for NaN: a new body has no pose at the start of the step
      double inverse_kg = inverse_mass_at(world.bodies()[contact.slot_a], point.from_a, contact.normal);
      if (!contact.b_fixed) inverse_kg += inverse_mass_at(world.bodies()[contact.slot_b], point.from_b, contact.normal);
      if (inverse_kg > 0) sum_J += 0.5 * omega * omega / inverse_kg * gap_m * gap_m;
    }
  return sum_J;
}

}  // namespace

bool energy_balance_is_complete(const Scene& scene) noexcept {
  if (scene.effects.kinematic || scene.effects.attraction || scene.effects.restitution) return false;
  return std::none_of(scene.effect_data.joints.begin(), scene.effect_data.joints.end(),
                      [](const auto& joint) { return joint.driven; });
}

double springs_J(const physics::World& world, double contact_hertz, double slop_m) noexcept {
  return contact_springs_J(world, contact_hertz, slop_m) + world.joint_springs_J(contact_hertz);
}

}  // namespace tactus::sim
