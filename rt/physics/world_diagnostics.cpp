// Energy, momentum and hash of a world.
#include <algorithm>
#include <utility>

#include "rt/physics/state_fields.h"
#include "rt/physics/world.h"

namespace tactus::physics {

double World::kinetic_energy() const noexcept {
  double sum = 0.0;
  for (const Body& body : bodies_) sum += physics::kinetic_energy(body);
  return sum;
}

double World::potential_energy(const Vec3d& gravity) const noexcept {
  double sum = 0.0;
  for (const Body& body : bodies_) sum -= body.mass * body.gravity_scale * dot(gravity, body.motion.pose.position);
  return sum;
}

double World::joint_springs_J(double contact_hertz) const noexcept {
  const Joints* const joints = effects_.find<Joints>();
  if (joints == nullptr) return 0.0;
  frozen_in_solve_.resize(bodies_.size());
  std::copy(frozen_.begin(), frozen_.end(), frozen_in_solve_.begin());
  if (const auto* const scripted = effects_.find<ScriptedMotion>())
    for (const KinematicScript& script : scripted->scripts())
      if (const auto slot = slot_of(script.id)) frozen_in_solve_[number_of(*slot)] = 1;
  return joints->springs_J(bodies(), fixed_bodies(), frozen_in_solve_.span(), contact_hertz);
}

Wrenchd World::momentum() const noexcept {
  Wrenchd sum;
  for (const Body& body : bodies_) {
    const Quatd& q = body.motion.pose.rotation;
    const Vec3d linear = body.mass * body.motion.velocity.linear;
    const Vec3d spin = rotate(q, scale(body.inertia, rotate_inverse(q, body.motion.velocity.angular)));
    sum += Wrenchd{linear, cross(body.motion.pose.position, linear) + spin};
  }
  return sum;
}

std::uint64_t World::state_hash() const noexcept {
  StateHash io;
  for (Body body : bodies_) fields(io, body.id, body.motion.pose, body.motion.velocity);
  return io.hash.value();
}

}  // namespace tactus::physics
