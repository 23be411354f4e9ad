// A hand that follows a scene's script and holds the simulated device's arm, without the device's electronics.
//
// The motion of device and hand is hal::Plant's; the force of the coupling acts on it after the device's transport
// delay. The encoder is ideal or real; its reading is the coupling's target in each tick. Thread: one.
// Frame: world. Units: SI. Same arguments, same bits.
#pragma once

#include <deque>

#include "hal/hand.h"
#include "hal/plant.h"
#include "rt/haptics/coupling/sub_world.h"
#include "rt/haptics/device_placement.h"
#include "rt/haptics/velocity_estimator.h"

namespace tactus::experiment {

class ScriptedArm {
 public:
  // `hand`: in the device's frame. The arm starts at rest at the first pose of its path.
  ScriptedArm(const hal::DeviceProfile& profile, const hal::HandModel& hand,
              const haptics::DevicePlacement::Config& placement, double period_s);

  // Advances the arm by one period. `on_device`: force on the device in the previous tick [N, N m, world].
  void advance(const Wrenchd& on_device);

  haptics::DeviceTarget ideal() const;                               // exact tool pose
  const haptics::DeviceTarget& encoded() const { return encoded_; }  // quantised pose, velocity estimated from it

 private:
  void encode();

  hal::DeviceProfile profile_;
  hal::HandModel hand_;
  haptics::DevicePlacement placement_;
  haptics::VelocityEstimator velocity_;
  hal::Plant plant_;
  double period_s_, time_s_{0};
  std::deque<Wrenchd> under_way_;  // commands that have not arrived, oldest first
  haptics::DeviceTarget encoded_;
};

}  // namespace tactus::experiment
