// The mechanics that an arm of simulated drives moves: the plant of the described arm and the hand on its tool, seen
// from the drives' shafts.
//
// A period is a fixed number of sub-steps, in each of which every drive's torque follows its shaft's speed, because
// drives close their damping faster than any host. Thread: construction, hold_hand(), restart_clock() [setup]; the rest
// [rt], by one thread: no allocation, no lock, bounded. Frame: the device's. Units: SI; torques, angles: of the shafts.
#pragma once

#include "hal/drives/simulated_rack.h"
#include "hal/hand.h"
#include "hal/plant.h"

namespace tactus::hal {

class ArmMechanics {
 public:
  static constexpr unsigned kSubSteps = 16;  // per period

  ArmMechanics(const DeviceProfile& profile, const HandModel& hand, std::int64_t period_ns)
      : description_(profile.description.drives),
        kinematics_(profile.kinematics),
        hand_(hand),
        plant_(profile.plant, hand.parameters(), hand.target_at(0.0).pose, profile.kinematics),
        period_ns_(static_cast<double>(period_ns)) {}

  // Advances by one period. `torque_Nm(axis, speed_rad_per_s, time_s)`: torque of a drive on its shaft; called once per
  // axis and sub-step, whose length is time_s.
  template <class Torque>
  void advance(Torque&& torque_Nm) noexcept {
    const double h_s = period_ns_ * 1e-9 / kSubSteps;
    for (unsigned step = 1; step <= kSubSteps; ++step) {
      const AxisVector rate = rates();
      AxisVector effort{};
      for (unsigned i = 0; i < description_.axes.size(); ++i) {
        const DriveAxis& axis = description_.axes[i];
        effort[i] = axis.sign * axis.ratio * torque_Nm(i, shaft_of(i, rate).speed_rad_per_s, h_s);
      }
      const double time_s = static_cast<double>(tick_) * period_ns_ * 1e-9 + h_s * step;
      plant_.step(h_s, effort, false, hand_.target_at(hand_held_ ? 0.0 : time_s));
    }
    ++tick_;
  }

  DriveShafts shafts() const noexcept {
    const AxisVector rate = rates();
    DriveShafts shafts;
    for (unsigned i = 0; i < description_.axes.size(); ++i) shafts[i] = shaft_of(i, rate);
    return shafts;
  }
  // The wrench at the tool that these shaft torques cause.
  Wrenchd wrench_of(const AxisVector& torques_Nm) const noexcept {
    AxisVector effort{};
    for (unsigned i = 0; i < description_.axes.size(); ++i)
      effort[i] = description_.axes[i].sign * description_.axes[i].ratio * torques_Nm[i];
    return kinematics_.wrench_of(plant_.coordinates(), effort);
  }

  // Starts the hand's path. A held hand stays at the start of its path until then.
  void restart_clock() noexcept {
    tick_ = 0;
    hand_held_ = false;
  }
  void hold_hand() noexcept { hand_held_ = true; }
  const Plant& plant() const noexcept { return plant_; }

 private:
  AxisVector rates() const noexcept { return kinematics_.rates_of(plant_.coordinates(), plant_.twist()); }
  DriveShaft shaft_of(unsigned axis, const AxisVector& rate) const noexcept {
    const DriveAxis& of = description_.axes[axis];
    return {of.offset_rad + of.sign * of.ratio * plant_.coordinates()[axis], of.sign * of.ratio * rate[axis]};
  }

  DriveDescription description_;
  Kinematics kinematics_;
  HandModel hand_;
  Plant plant_;
  double period_ns_;
  std::uint64_t tick_{0};
  bool hand_held_{false};
};

}  // namespace tactus::hal
