#include "tools/python/hand_device.h"

#include <cmath>

#include "rt/base/rotation_vector.h"
#include "tools/library/values.h"
#include "tools/session/session.h"

namespace tactus::python {
namespace {

constexpr unsigned kSubSteps = hal::SimulationOptions{}.sub_steps;

}  // namespace

HandDevice::HandDevice(const sim::Scene& scene, const hal::DeviceProfile& profile, double period_s, AskHand ask)
    : placement_(scene.device),
      profile_(profile),
      hand_(session::make_hand(scene)),
      period_s_(period_s),
      ask_(std::move(ask)),
      state_(initial_state()) {}

HandDevice::State HandDevice::initial_state() const {
  const Posed start = hand_.target_at(0.0).pose;
  State state{.plant = hal::Plant(profile_.plant, hand_.parameters(), start, profile_.kinematics),
              .target = start,
              .push = {},
              .commands = {},
              .felt = {}};
  state.commands.resize(profile_.transport_delay_ticks);
  return state;
}

DeviceProperties HandDevice::properties() const {
  const haptics::DeviceProperties& from = profile_.properties;
  DeviceProperties to;
  to.has_rotation = from.has_rotation;
  to.workspace_radius_m = from.workspace_radius_m;
  to.max_speed_m_per_s = from.max_speed_m_per_s;
  to.max_angular_speed_rad_per_s = from.max_angular_speed_rad_per_s;
  to.max_force_N = from.max_force_N;
  to.max_torque_Nm = from.max_torque_Nm;
  to.continuous_force_N = from.continuous_force_N;
  to.continuous_torque_Nm = from.continuous_torque_Nm;
  to.position_quantum_m = from.position_quantum_m;
  to.rotation_quantum_rad = from.rotation_quantum_rad;
  to.mass_kg = from.mass_kg;
  to.damping_Ns_per_m = from.damping_Ns_per_m;
  to.inertia_kg_m2 = from.inertia_kg_m2;
  to.damping_Nms_per_rad = from.damping_Nms_per_rad;
  to.delay_s = profile_.transport_delay_ticks * period_s_;
  to.coulomb_friction_N = from.coulomb_friction_N;
  to.coulomb_friction_Nm = from.coulomb_friction_Nm;
  return to;
}

Error HandDevice::start(double) {
  state_ = initial_state();
  return {};
}

Reading HandDevice::read(DeviceSample& sample) noexcept {
  if (state_.reads++ > 0) advance();
  apply_next_command();
  const Posed tool = measured();
  sample.position_m = library::to_public(tool.position);
  sample.rotation = library::to_public(tool.rotation);
  return Reading::kFresh;
}

void HandDevice::write(const DeviceCommand& command) noexcept { state_.commands.push_back(command); }

Posed HandDevice::measured() const noexcept {
  hal::AxisVector coordinates = state_.plant.coordinates();
  for (unsigned i = 0; i < hal::kAxisCount; ++i)
    coordinates[i] = std::round(coordinates[i] / profile_.quantum[i]) * profile_.quantum[i];
  return profile_.kinematics.pose_of(coordinates);
}

void HandDevice::advance() noexcept {
  const Quatd world_from_device = placement_.world_from_device.rotation;
  const HandAsked asked{.tick = state_.reads - 1,
                        .tool = to_world(measured()),
                        .force_N = library::to_public(rotate(world_from_device, state_.felt.force)),
                        .torque_Nm = library::to_public(rotate(world_from_device, state_.felt.torque))};
  const bool pushed = state_.push.has_value();
  const Posed from = state_.target;
  HandWish wish;
  if (ask_(asked, wish)) {
    state_.push.reset();
    if (const auto* push = std::get_if<HandPush>(&wish))
      state_.push = Wrenchd{rotate_inverse(world_from_device, library::to_inner(push->force_N)),
                            rotate_inverse(world_from_device, library::to_inner(push->torque_Nm))};
    else
      state_.target = to_device(std::get<HandPose>(wish));
  }
  // A hand that ceases to push holds the tool from where it is.
  step_plant(pushed ? state_.plant.pose() : from);
}

// The target moves from the last to the next at constant velocity.
void HandDevice::step_plant(const Posed& from) noexcept {
  if (state_.push) {
    for (unsigned s = 1; s <= kSubSteps; ++s)
      state_.plant.step_pushed(period_s_ / kSubSteps, state_.effort, state_.brake, *state_.push);
    return;
  }
  const Vec3d move = state_.target.position - from.position;
  const Vec3d turn = rotation_vector_of(state_.target.rotation * conjugate(from.rotation));
  const Twistd twist{move * (1.0 / period_s_), turn * (1.0 / period_s_)};
  for (unsigned s = 1; s <= kSubSteps; ++s) {
    const double share = static_cast<double>(s) / kSubSteps;
    const Posed target{from.position + move * share, quat_from_rotation_vector(turn * share) * from.rotation};
    state_.plant.step(period_s_ / kSubSteps, state_.effort, state_.brake, {target, twist});
  }
}

void HandDevice::apply_next_command() noexcept {
  const DeviceCommand command = state_.commands.front();
  state_.commands.pop_front();
  state_.felt = {};
  if (command.force_on) state_.felt = {library::to_inner(command.force_N), library::to_inner(command.torque_Nm)};
  state_.effort = profile_.kinematics.efforts_of(state_.plant.coordinates(), state_.felt);
  state_.brake = command.brake;
}

HandPose HandDevice::to_world(const Posed& tool) const noexcept {
  const Posed scaled{tool.position * placement_.motion_scale, tool.rotation};
  const Posed world = placement_.world_from_device * scaled;
  return {library::to_public(world.position), library::to_public(world.rotation)};
}

Posed HandDevice::to_device(const HandPose& pose) const noexcept {
  const Posed world{library::to_inner(pose.position_m), library::to_inner(pose.rotation)};
  const Posed device = inverse(placement_.world_from_device) * world;
  return {device.position * (1.0 / placement_.motion_scale), device.rotation};
}

}  // namespace tactus::python
