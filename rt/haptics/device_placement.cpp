#include "rt/haptics/device_placement.h"

namespace tactus::haptics {
namespace {

Vec3d placed_position(const DevicePlacement::Config& config, const Vec3d& tool) noexcept {
  return config.world_from_device.position + config.motion_scale * rotate(config.world_from_device.rotation, tool);
}

// The rotation in the frame of a 3-DoF tool is ignored.
Quatd placed_rotation(const DevicePlacement::Config& config, const Quatd& tool) noexcept {
  return config.has_rotation ? config.world_from_device.rotation * tool : config.world_from_device.rotation;
}

}  // namespace

Posed DevicePlacement::world_from_target(const Posed& device_from_tool) const noexcept {
  return {placed_position(config, device_from_tool.position) + state.offset,
          normalized(placed_rotation(config, device_from_tool.rotation) * state.tool_offset)};
}

Twistd DevicePlacement::target_twist(const Twistd& tool_twist) const noexcept {
  const Quatd& world_from_device = config.world_from_device.rotation;
  return {config.motion_scale * rotate(world_from_device, tool_twist.linear),
          config.has_rotation ? rotate(world_from_device, tool_twist.angular) : Vec3d{}};
}

Wrenchd DevicePlacement::device_wrench(const Wrenchd& world_wrench) const noexcept {
  const Quatd& world_from_device = config.world_from_device.rotation;
  return {config.motion_scale * rotate_inverse(world_from_device, world_wrench.force),
          config.has_rotation ? rotate_inverse(world_from_device, world_wrench.torque) : Vec3d{}};
}

void DevicePlacement::clutch_to(const Posed& world_from_target, const Posed& device_from_tool) noexcept {
  state.offset = world_from_target.position - placed_position(config, device_from_tool.position);
  state.tool_offset =
      normalized(conjugate(placed_rotation(config, device_from_tool.rotation)) * world_from_target.rotation);
}

}  // namespace tactus::haptics
