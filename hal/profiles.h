// Device profiles: what the program needs of a device, computed from its description; and two built-in descriptions.
//
// A built-in description stands for a class of devices, not for one measured product: the comments in profiles.cpp say
// which figures are a maker's class figures and which are estimates; hal/devices/ contains them as files.
// Frame: the device's. Units: SI. Thread: [setup] (the first use computes the profiles); then constants, [any].
#pragma once

#include <span>
#include <string_view>

#include "firmware/controller.h"
#include "hal/device_description.h"
#include "hal/kinematics/workspace_bounds.h"
#include "rt/haptics/device.h"

namespace tactus::hal {

// The mechanics, apparent at the tool: isotropic, gravity balanced.
struct PlantParameters {
  double mass_kg{0}, inertia_kg_m2{0};
  double damping_Ns_per_m{0}, damping_Nms_per_rad{0};
  double coulomb_force_N{0}, coulomb_torque_Nm{0};
  double brake_damping_Ns_per_m{0}, brake_damping_Nms_per_rad{0};  // added while the motors are shorted
  double stop_radius_m{0};  // distance of the mechanical stop (no rebound) from the centre
  AxisVector max_effort{};  // N, N m: where the amplifiers saturate
  bool has_rotation{true};
};

struct DeviceProfile {
  DeviceDescription description;
  std::string name;
  haptics::DeviceProperties properties;  // the device sets delay_s from transport_delay_ticks and its period
  Kinematics kinematics;
  AxisVector quantum{};    // m or rad per encoder count
  WorkspaceBounds bounds;  // the tool's limits, converted to the axes
  PlantParameters plant;
  // Damping of the drives at the tool, the least over workspace and directions; contained in `properties`, not in
  // `plant`.
  double drive_damping_Ns_per_m{0}, drive_damping_Nms_per_rad{0};
  unsigned transport_delay_ticks{1};  // from a sample to the effort computed from it, beyond the sample-and-hold
};

// The quanta at the tool are the largest over the workspace. The amplifiers supply peak force and peak torque together
// in the worst pose. Precondition: find_mistake(description) reports none.
DeviceProfile make_profile(const DeviceDescription& description);

// virtuose6d, desk3d.
std::span<const DeviceDescription> built_in_descriptions() noexcept;
std::span<const DeviceProfile> all_profiles() noexcept;

// Null for an unknown name.
const DeviceProfile* find_profile(std::string_view name) noexcept;

// Ratio of firmware_config's effort limits to what the description needs: the host's limit acts first, and a wrench at
// the limit passes the firmware in spite of rounding.
inline constexpr double kFirmwareMargin = 1.01;

// The firmware's configuration for a profile. `period_us` is the control period. The firmware limits axes, not the
// tool: its limits accept every wrench that the host may send at any pose, and no more effort per axis than that needs.
firmware::Config firmware_config(const DeviceProfile& profile, std::uint32_t period_us) noexcept;

}  // namespace tactus::hal
