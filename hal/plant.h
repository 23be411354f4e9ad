// The mechanics of the simulated device with a hand on its tool: a mass and an isotropic inertia with viscous damping,
// Coulomb friction, amplifier saturation, and two mechanical stops: the workspace sphere and the wrist's pitch limit.
//
// Semi-implicit: damping, the hand's spring and friction act on the velocity at the end of the sub-step, so none of
// them can add energy or chatter; friction sticks whenever it can. Energy account: kinetic energy changes by exactly
// the sum of the works, each computed with the mean velocity of the sub-step. Frame: the device's. Units: SI. Thread:
// [rt], the owner's; no allocation, bounded.
#pragma once

#include "hal/hand.h"
#include "hal/profiles.h"

namespace tactus::hal {

// J: what each source has done on device and hand together since the start; dissipation is negative.
struct PlantWork {
  double motors{0}, hand{0}, viscous{0}, coulomb{0}, stops{0};
};

class Plant {
 public:
  // [setup] At rest at `device_from_tool`; a pose outside the stops is moved inside.
  Plant(const PlantParameters& parameters, const HandParameters& hand, const Posed& device_from_tool,
        const Kinematics& kinematics = {}) noexcept;

  // One sub-step of `h_s` seconds. `motor_effort` (N, N m) is clamped where the amplifiers saturate. `shorted`: no
  // effort, added damping.
  void step(double h_s, const AxisVector& motor_effort, bool shorted, const HandTarget& target) noexcept;
  // Same, with a hand that pushes the tool with `push` wherever the tool is, instead of holding it to a target.
  void step_pushed(double h_s, const AxisVector& motor_effort, bool shorted, const Wrenchd& push) noexcept;

  Posed pose() const noexcept { return kinematics_.pose_of(coordinates_); }  // device_from_tool
  const AxisVector& coordinates() const noexcept { return coordinates_; }    // m, rad
  const Twistd& twist() const noexcept { return twist_; }
  const Wrenchd& hand_wrench() const noexcept { return hand_wrench_; }    // on the tool, last sub-step
  const Wrenchd& motor_wrench() const noexcept { return motor_wrench_; }  // on the tool, last sub-step
  const PlantWork& work() const noexcept { return work_; }
  double kinetic_energy_J() const noexcept;

 private:
  struct Line;  // one vector equation of motion: translation or rotation
  void set_motor_wrench(const AxisVector& motor_effort, bool shorted) noexcept;
  // The callers add the hand's terms.
  Line translation(double h_s, bool shorted) noexcept;
  Line rotation(double h_s, bool shorted) noexcept;
  Vec3d advance(const Line& line, const Vec3d& speed) noexcept;
  void hit_stops() noexcept;

  void move(double h_s) noexcept;
  void hit_sphere() noexcept;
  void hit_pitch_stop() noexcept;

  Kinematics kinematics_;
  PlantParameters parameters_;
  HandParameters hand_;
  double mass_kg_, inertia_kg_m2_;  // of device and hand together
  AxisVector coordinates_{};
  Twistd twist_;
  Wrenchd hand_wrench_, motor_wrench_;
  PlantWork work_;
};

}  // namespace tactus::hal
