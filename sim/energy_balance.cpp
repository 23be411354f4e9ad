#include "sim/energy_balance.h"

#include <numbers>

#include "sim/model/scene.h"

namespace tactus::sim {
namespace {

// A body at a contact: its motion since the start of the step, and how it answers to an impulse.
class ContactSide {
 public:
  ContactSide(const physics::World& world, std::uint32_t slot, const Vec3d& n) noexcept : n_(n) {
    const physics::Body& body = world.bodies()[slot];
    const Posed &start = world.last_poses()[slot], &now = body.motion.pose;
    moved_ = now.position - start.position;
    turned_ = now.rotation * conjugate(start.rotation);
    inverse_kg_ = 1 / body.mass;
    body_from_world_ = conjugate(now.rotation);
    inverse_inertia_ = {1 / body.inertia.x, 1 / body.inertia.y, 1 / body.inertia.z};
  }
  // Of the point at `arm` from the centre at the start of the step, along the normal.
  double moved_m(const Vec3d& arm) const noexcept { return dot(n_, moved_ + rotate(turned_, arm) - arm); }
  double inverse_mass_per_kg(const Vec3d& arm) const noexcept {
    const Vec3d turn = rotate(body_from_world_, cross(arm, n_));
    return inverse_kg_ + dot(turn, scale(inverse_inertia_, turn));
  }

 private:
  Vec3d n_, moved_, inverse_inertia_;
  Quatd turned_, body_from_world_;
  double inverse_kg_;
};

double contact_springs_J(const physics::World& world, double contact_hertz, double slop_m) noexcept {
  const double omega = 2 * std::numbers::pi * contact_hertz;
  double sum_J = 0;
  for (const auto& contact : world.contacts()) {
    const ContactSide a(world, contact.slot_a, contact.normal);
    const ContactSide b(world, contact.b_fixed ? contact.slot_a : contact.slot_b, contact.normal);  // fixed: not read
    for (std::uint32_t i = 0; i < contact.count; ++i) {
      const auto& point = contact.points[i];
      double gap_m = point.separation + slop_m - a.moved_m(point.from_a);
      if (!contact.b_fixed) gap_m += b.moved_m(point.from_b);
      if (!(gap_m < 0)) continue;  // also for NaN: a new body has no pose at the start of the step
      double inverse_kg = a.inverse_mass_per_kg(point.from_a);
      if (!contact.b_fixed) inverse_kg += b.inverse_mass_per_kg(point.from_b);
      if (inverse_kg > 0) sum_J += 0.5 * omega * omega / inverse_kg * gap_m * gap_m;
    }
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
