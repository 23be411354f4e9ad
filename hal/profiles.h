// What the program must know of a device, worked out from its description; and the two descriptions that are built in.
//
// A built-in description stands for a class of devices, not for one product that was measured: the comments in
// profiles.cpp say which figures are a maker's class figures and which are estimates; hal/devices/ holds them as files.
// Frame: the device's. Units: SI. Thread: [setup] (the first use of a name works it out); then constants, [any].
#pragma once

#include <span>
#include <string_view>

#include "firmware/controller.h"
#include "hal/device_description.h"
#include "hal/kinematics/reach.h"
#include "rt/haptics/device.h"

namespace tactus::hal {

// The mechanics as felt at the tool: isotropic, gravity balanced.
struct PlantParameters {
  double mass_kg{0}, inertia_kg_m2{0};
  double damping_Ns_per_m{0}, damping_Nms_per_rad{0};
  double coulomb_force_N{0}, coulomb_torque_Nm{0};
  double brake_damping_Ns_per_m{0}, brake_damping_Nms_per_rad{0};  // added while the motors are shorted
  double stop_radius_m{0};  // a mechanical stop, without rebound, at this distance from the centre
  AxisVector max_effort{};  // N, N m: where the amplifiers saturate
  bool has_rotation{true};
};

struct DeviceProfile {
  DeviceDescription description;
  std::string name;
  haptics::DeviceProperties properties;  // delay_s is set by the device, from the ticks below and its period
  Kinematics kinematics;
  AxisVector quantum{};  // m or rad per encoder count
  ReachBounds bounds;    // what the limits at the tool mean at the axes
  PlantParameters plant;
  unsigned transport_delay_ticks{1};  // from a sample to the effort that answers it, beyond the sample-and-hold
};

// The quanta at the tool are the worst over the workspace; the amplifiers give what peak force and peak torque at once
// need in the worst pose. The description must have no mistake.
DeviceProfile make_profile(const DeviceDescription& description);

// virtuose6d, desk3d.
std::span<const DeviceDescription> built_in_descriptions() noexcept;
std::span<const DeviceProfile> all_profiles() noexcept;

// Null for a name that is none.
const DeviceProfile* find_profile(std::string_view name) noexcept;

// Of firmware_config's effort limits over what the description needs, for rounding.
inline constexpr double kFirmwareMargin = 1.01;

// What the profile's firmware is configured with. `period_us` is the control period. The firmware knows axes, not the
// tool: its limits let every wrench through that the host may send, anywhere, and no axis more than its share of that.
firmware::Config firmware_config(const DeviceProfile& profile, std::uint32_t period_us) noexcept;

}  // namespace tactus::hal
