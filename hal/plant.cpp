#include "hal/plant.h"

#include <algorithm>
#include <cmath>

namespace tactus::hal {
namespace {

// Axis coordinates of a pose, by walking there: the rotation's error, turned into axis rates, closes in a few steps.
// Set-up only. It also keeps the pitch inside its limit.
AxisVector coordinates_of(const CartesianStage& kinematics, const Posed& pose) noexcept {
  AxisVector q{pose.position.x, pose.position.y, pose.position.z, 0, 0, 0};
  for (int i = 0; i < 200; ++i) {
    const Vec3d error = rotation_vector_of(pose.rotation * conjugate(kinematics.pose_of(q).rotation));
    const double angle = norm(error);
    if (angle < 1e-14) break;
    const AxisVector rate = kinematics.rates_of(q, {{}, error * std::min(1.0, 0.2 / angle)});
    for (unsigned axis = 3; axis < kAxisCount; ++axis) q[axis] += rate[axis];
    q[4] = std::clamp(q[4], -kPitchLimit_rad, kPitchLimit_rad);
  }
  return q;
}

}  // namespace

struct Plant::Line {
  double h, mass, damping, friction;  // s; kg, N s/m, N (or their rotary kin)
  double hand_stiffness, hand_damping;
  Vec3d motor, error, target_speed;  // N; target - position; m/s
  Vec3d* hand_force;                 // out: the hand's, on the tool
};

Plant::Plant(const PlantParameters& parameters, const HandParameters& hand, const Posed& device_from_tool) noexcept
    : parameters_(parameters),
      hand_(hand),
      mass_kg_(parameters.mass_kg + hand.mass_kg),
      inertia_kg_m2_(parameters.inertia_kg_m2 + hand.inertia_kg_m2) {
  Posed start = device_from_tool;
  if (!parameters.has_rotation) start.rotation = {};
  coordinates_ = coordinates_of(kinematics_, start);
  hit_stops();
}

void Plant::step(double h_s, const AxisVector& motor_effort, bool shorted, const HandTarget& target) noexcept {
  AxisVector effort{};
  if (!shorted)
    for (unsigned i = 0; i < kAxisCount; ++i)
      effort[i] = std::clamp(motor_effort[i], -parameters_.max_effort[i], parameters_.max_effort[i]);
  motor_wrench_ = kinematics_.wrench_of(coordinates_, effort);
  const PlantParameters& p = parameters_;

  const Vec3d position{coordinates_[0], coordinates_[1], coordinates_[2]};
  twist_.linear = advance({h_s, mass_kg_, p.damping_Ns_per_m + (shorted ? p.brake_damping_Ns_per_m : 0.0),
                           p.coulomb_force_N, hand_.stiffness_N_per_m, hand_.damping_Ns_per_m, motor_wrench_.force,
                           target.pose.position - position, target.twist.linear, &hand_wrench_.force},
                          twist_.linear);
  if (p.has_rotation) {
    const Vec3d error = small_rotation_vector(target.pose.rotation * conjugate(pose().rotation));
    twist_.angular =
        advance({h_s, inertia_kg_m2_, p.damping_Nms_per_rad + (shorted ? p.brake_damping_Nms_per_rad : 0.0),
                 p.coulomb_torque_Nm, hand_.stiffness_Nm_per_rad, hand_.damping_Nms_per_rad, motor_wrench_.torque,
                 error, target.twist.angular, &hand_wrench_.torque},
                twist_.angular);
  }
  const AxisVector rate = kinematics_.rates_of(coordinates_, twist_);
  for (unsigned i = 0; i < kAxisCount; ++i) coordinates_[i] += h_s * rate[i];
  hit_stops();
}

Vec3d Plant::advance(const Line& l, const Vec3d& speed) noexcept {
  // The hand's spring as it will be at the end of the sub-step: error - h (v+ - v_target).
  const double hand_rate = l.hand_damping + l.h * l.hand_stiffness;
  const double resistance = l.mass + l.h * (l.damping + hand_rate);
  const Vec3d push = l.motor + l.error * l.hand_stiffness + l.target_speed * l.hand_damping;
  const Vec3d momentum = speed * l.mass + push * l.h;  // resistance times the speed that would be without friction
  const double holding = l.h * l.friction, size = norm(momentum);
  const bool sticks = size <= holding;
  const Vec3d next = sticks ? Vec3d{} : momentum * ((1.0 - holding / size) / resistance);

  const Vec3d hand_force = push - l.motor - next * hand_rate;
  const Vec3d viscous_force = next * -l.damping;
  // What is left of the change of momentum is friction's, stuck or slipping.
  const Vec3d friction_impulse = (next - speed) * l.mass - (l.motor + hand_force + viscous_force) * l.h;
  const Vec3d mean_speed = (speed + next) * 0.5;
  energy_.motors += l.h * dot(l.motor, mean_speed);
  energy_.hand += l.h * dot(hand_force, mean_speed);
  energy_.viscous += l.h * dot(viscous_force, mean_speed);
  energy_.coulomb += dot(friction_impulse, mean_speed);
  *l.hand_force = hand_force;
  return next;
}

void Plant::hit_stops() noexcept {
  const double before = kinetic_energy_J();
  const Vec3d position{coordinates_[0], coordinates_[1], coordinates_[2]};
  const double distance = norm(position);
  if (distance > parameters_.stop_radius_m) {
    const Vec3d outwards = position * (1.0 / distance);
    for (int i = 0; i < 3; ++i) coordinates_[static_cast<unsigned>(i)] = outwards[i] * parameters_.stop_radius_m;
    const double speed = dot(twist_.linear, outwards);
    if (speed > 0.0) twist_.linear -= outwards * speed;
  }
  if (std::abs(coordinates_[4]) > kPitchLimit_rad) {
    coordinates_[4] = std::copysign(kPitchLimit_rad, coordinates_[4]);
    // The pitch axis is at right angles to the two others: taking its share of the speed leaves theirs alone.
    const Vec3d pitch_axis = kinematics_.twist_of(coordinates_, {0, 0, 0, 0, 1, 0}).angular;
    const double speed = dot(twist_.angular, pitch_axis);
    if (speed * coordinates_[4] > 0.0) twist_.angular -= pitch_axis * speed;
  }
  energy_.stops += kinetic_energy_J() - before;
}

double Plant::kinetic_energy_J() const noexcept {
  return 0.5 * (mass_kg_ * norm_squared(twist_.linear) + inertia_kg_m2_ * norm_squared(twist_.angular));
}

}  // namespace tactus::hal
