#include "tools/experiment/coupling/scripted_arm.h"

#include <cmath>

namespace tactus::experiment {
namespace {

constexpr unsigned kSubSteps = 4;  // of the mechanics, as hal::SimulatedDevice

}  // namespace

ScriptedArm::ScriptedArm(const hal::DeviceProfile& profile, const hal::HandModel& hand,
                         const haptics::DevicePlacement::Config& placement, double period_s)
    : profile_(profile),
      hand_(hand),
      plant_(profile.plant, hand.parameters(), hand.target_at(0).pose, profile.kinematics),
      period_s_(period_s),
      under_way_(profile.transport_delay_ticks) {
  placement_.config = placement;
  velocity_.config = haptics::VelocityEstimator::Config::of(profile.properties, period_s);
  encode();
}

void ScriptedArm::advance(const Wrenchd& on_device) {
  under_way_.push_back(placement_.device_wrench(on_device));
  const hal::AxisVector effort = profile_.kinematics.efforts_of(plant_.coordinates(), under_way_.front());
  under_way_.pop_front();
  const double h_s = period_s_ / kSubSteps;
  for (unsigned s = 1; s <= kSubSteps; ++s) plant_.step(h_s, effort, false, hand_.target_at(time_s_ + s * h_s));
  time_s_ += period_s_;
  encode();
}

haptics::DeviceTarget ScriptedArm::ideal() const {
  return {true, placement_.world_from_target(plant_.pose()), placement_.target_twist(plant_.twist())};
}

void ScriptedArm::encode() {
  hal::AxisVector counted = plant_.coordinates();
  for (unsigned i = 0; i < hal::kAxisCount; ++i)
    if (profile_.quantum[i] > 0) counted[i] = profile_.quantum[i] * std::round(counted[i] / profile_.quantum[i]);
  const Posed pose = profile_.kinematics.pose_of(counted);
  encoded_ = {true, placement_.world_from_target(pose), placement_.target_twist(velocity_.update(pose))};
}

}  // namespace tactus::experiment
