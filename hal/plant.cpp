#include "hal/plant.h"

#include <algorithm>
#include <cmath>

namespace tactus::hal {
struct Plant::Line {
  double h, mass, damping, friction;  // s; kg, N s/m, N, or their rotary counterparts
  double hand_stiffness, hand_damping;
  Vec3d motor, error, target_speed;  // N; target - position; m/s
  Vec3d* hand_force;                 // out: the hand's, on the tool
};

Plant::Plant(const PlantParameters& parameters, const HandParameters& hand, const Posed& device_from_tool,
             const Kinematics& kinematics) noexcept
    : kinematics_(kinematics),
      parameters_(parameters),
      hand_(hand),
      mass_kg_(parameters.mass_kg + hand.mass_kg),
      inertia_kg_m2_(parameters.inertia_kg_m2 + hand.inertia_kg_m2) {
  Posed start = device_from_tool;
  if (!parameters.has_rotation) start.rotation = {};
  const double distance = norm(start.position);
  if (distance > parameters.stop_radius_m) start.position = start.position * (parameters.stop_radius_m / distance);
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

  const Posed here = pose();
  twist_.linear = advance({h_s, mass_kg_, p.damping_Ns_per_m + (shorted ? p.brake_damping_Ns_per_m : 0.0),
                           p.coulomb_force_N, hand_.stiffness_N_per_m, hand_.damping_Ns_per_m, motor_wrench_.force,
                           target.pose.position - here.position, target.twist.linear, &hand_wrench_.force},
                          twist_.linear);
  if (p.has_rotation) {
    const Vec3d error = small_rotation_vector(target.pose.rotation * conjugate(here.rotation));
    twist_.angular =
        advance({h_s, inertia_kg_m2_, p.damping_Nms_per_rad + (shorted ? p.brake_damping_Nms_per_rad : 0.0),
                 p.coulomb_torque_Nm, hand_.stiffness_Nm_per_rad, hand_.damping_Nms_per_rad, motor_wrench_.torque,
                 error, target.twist.angular, &hand_wrench_.torque},
                twist_.angular);
  }
  move(h_s);
  hit_stops();
}

// Midpoint rule: for a straight tool path the axes' paths are curved.
void Plant::move(double h_s) noexcept {
  AxisVector half_way = coordinates_;
  AxisVector rate = kinematics_.rates_of(coordinates_, twist_);
  for (unsigned i = 0; i < kAxisCount; ++i) half_way[i] += 0.5 * h_s * rate[i];
  rate = kinematics_.rates_of(half_way, twist_);
  for (unsigned i = 0; i < kAxisCount; ++i) coordinates_[i] += h_s * rate[i];
}

Vec3d Plant::advance(const Line& l, const Vec3d& speed) noexcept {
  // Implicit spring of the hand: its error at the end of the sub-step is error - h (v+ - v_target).
  const double hand_rate = l.hand_damping + l.h * l.hand_stiffness;
  const double resistance = l.mass + l.h * (l.damping + hand_rate);
  const Vec3d push = l.motor + l.error * l.hand_stiffness + l.target_speed * l.hand_damping;
  const Vec3d momentum = speed * l.mass + push * l.h;  // resistance x the velocity without friction
  const double holding = l.h * l.friction, size = norm(momentum);
  const bool sticks = size <= holding;
  const Vec3d next = sticks ? Vec3d{} : momentum * ((1.0 - holding / size) / resistance);

  const Vec3d hand_force = push - l.motor - next * hand_rate;
  const Vec3d viscous_force = next * -l.damping;
  // The rest of the momentum change is the friction impulse, sticking or slipping.
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
  hit_sphere();
  if (std::abs(coordinates_[kPitchAxis]) > kPitchLimit_rad) hit_pitch_stop();
  energy_.stops += kinetic_energy_J() - before;
}

void Plant::hit_sphere() noexcept {
  constexpr int kSteps = 4;  // Newton steps along the tangent back to the sphere; two are usually enough
  for (int i = 0; i < kSteps; ++i) {
    const Vec3d position = pose().position;
    const double distance = norm(position);
    if (distance <= parameters_.stop_radius_m) return;
    const Vec3d outwards = position * (1.0 / distance);
    const AxisVector back = kinematics_.rates_of(coordinates_, {outwards * (parameters_.stop_radius_m - distance), {}});
    for (unsigned axis = 0; axis < kAxisCount; ++axis) coordinates_[axis] += back[axis];
    const double speed = dot(twist_.linear, outwards);
    if (speed > 0.0) twist_.linear -= outwards * speed;
  }
}

// Applies the impulse on the pitch axis that stops it: the tool's twist changes along that axis's row of the inverse.
void Plant::hit_pitch_stop() noexcept {
  coordinates_[kPitchAxis] = std::copysign(kPitchLimit_rad, coordinates_[kPitchAxis]);
  const double rate = kinematics_.rates_of(coordinates_, twist_)[kPitchAxis];
  if (rate * coordinates_[kPitchAxis] <= 0.0) return;
  const Wrenchd row = kinematics_.wrench_of(coordinates_, unit_axis(kPitchAxis));
  const double mobility = norm_squared(row.force) / mass_kg_ + norm_squared(row.torque) / inertia_kg_m2_;
  const double impulse = rate / mobility;
  twist_.linear -= row.force * (impulse / mass_kg_);
  twist_.angular -= row.torque * (impulse / inertia_kg_m2_);
}

double Plant::kinetic_energy_J() const noexcept {
  return 0.5 * (mass_kg_ * norm_squared(twist_.linear) + inertia_kg_m2_ * norm_squared(twist_.angular));
}

}  // namespace tactus::hal
