#include "hal/plant.h"

#include <algorithm>
#include <cmath>

namespace tactus::hal {
struct Plant::Line {
  double h, mass, damping, friction;  // s; kg, N s/m, N, or their rotary counterparts
  Vec3d motor;
  Vec3d* hand_force;  // out: the hand's, on the tool
  double hand_stiffness{0}, hand_damping{0};
  Vec3d error{}, target_speed{};  // target - position; m/s
  Vec3d push{};                   // of a hand without stiffness
  bool pushes{false};
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

void Plant::set_motor_wrench(const AxisVector& motor_effort, bool shorted) noexcept {
  AxisVector effort{};
  if (!shorted)
    for (unsigned i = 0; i < kAxisCount; ++i)
      effort[i] = std::clamp(motor_effort[i], -parameters_.max_effort[i], parameters_.max_effort[i]);
  motor_wrench_ = kinematics_.wrench_of(coordinates_, effort);
}

Plant::Line Plant::translation(double h_s, bool shorted) noexcept {
  const PlantParameters& p = parameters_;
  const double damping = p.damping_Ns_per_m + (shorted ? p.brake_damping_Ns_per_m : 0.0);
  return {.h = h_s,
          .mass = mass_kg_,
          .damping = damping,
          .friction = p.coulomb_force_N,
          .motor = motor_wrench_.force,
          .hand_force = &hand_wrench_.force};
}

Plant::Line Plant::rotation(double h_s, bool shorted) noexcept {
  const PlantParameters& p = parameters_;
  const double damping = p.damping_Nms_per_rad + (shorted ? p.brake_damping_Nms_per_rad : 0.0);
  return {.h = h_s,
          .mass = inertia_kg_m2_,
          .damping = damping,
          .friction = p.coulomb_torque_Nm,
          .motor = motor_wrench_.torque,
          .hand_force = &hand_wrench_.torque};
}

void Plant::step(double h_s, const AxisVector& motor_effort, bool shorted, const HandTarget& target) noexcept {
  set_motor_wrench(motor_effort, shorted);
  const Posed here = pose();
  Line line = translation(h_s, shorted);
  line.hand_stiffness = hand_.stiffness_N_per_m;
  line.hand_damping = hand_.damping_Ns_per_m;
  line.error = target.pose.position - here.position;
  line.target_speed = target.twist.linear;
  twist_.linear = advance(line, twist_.linear);
  if (parameters_.has_rotation) {
    line = rotation(h_s, shorted);
    line.hand_stiffness = hand_.stiffness_Nm_per_rad;
    line.hand_damping = hand_.damping_Nms_per_rad;
    line.error = small_rotation_vector(target.pose.rotation * conjugate(here.rotation));
    line.target_speed = target.twist.angular;
    twist_.angular = advance(line, twist_.angular);
  }
  move(h_s);
  hit_stops();
}

void Plant::step_pushed(double h_s, const AxisVector& motor_effort, bool shorted, const Wrenchd& push) noexcept {
  set_motor_wrench(motor_effort, shorted);
  Line line = translation(h_s, shorted);
  line.push = push.force;
  line.pushes = true;
  twist_.linear = advance(line, twist_.linear);
  if (parameters_.has_rotation) {
    line = rotation(h_s, shorted);
    line.push = push.torque;
    line.pushes = true;
    twist_.angular = advance(line, twist_.angular);
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
  const Vec3d push =
      l.pushes ? l.motor + l.push : l.motor + l.error * l.hand_stiffness + l.target_speed * l.hand_damping;
  const Vec3d momentum = speed * l.mass + push * l.h;  // resistance x the velocity without friction
  const double holding = l.h * l.friction, size = norm(momentum);
  const bool sticks = size <= holding;
  const Vec3d next = sticks ? Vec3d{} : momentum * ((1.0 - holding / size) / resistance);

  const Vec3d hand_force = l.pushes ? l.push : push - l.motor - next * hand_rate;
  const Vec3d viscous_force = next * -l.damping;
  // The rest of the momentum change is the friction impulse, sticking or slipping.
  const Vec3d friction_impulse = (next - speed) * l.mass - (l.motor + hand_force + viscous_force) * l.h;
  const Vec3d mean_speed = (speed + next) * 0.5;
  work_.motors += l.h * dot(l.motor, mean_speed);
  work_.hand += l.h * dot(hand_force, mean_speed);
  work_.viscous += l.h * dot(viscous_force, mean_speed);
  work_.coulomb += dot(friction_impulse, mean_speed);
  *l.hand_force = hand_force;
  return next;
}

void Plant::hit_stops() noexcept {
  const double before = kinetic_energy_J();
  hit_sphere();
  if (std::abs(coordinates_[kPitchAxis]) > kPitchLimit_rad) hit_pitch_stop();
  work_.stops += kinetic_energy_J() - before;
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
