// What the simulated devices are: two classes of real ones, as figures.
//
// A profile describes a class, not one product that was measured: the comments in profiles.cpp say which figures are a
// maker's class figures and which are estimates. Units: SI. Thread: [any]; constants.
#pragma once

#include <span>
#include <string_view>

#include "firmware/controller.h"
#include "hal/axes.h"
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
  std::string_view name;
  haptics::DeviceProperties properties;  // delay_s is set by the device, from the ticks below and its period
  PlantParameters plant;
  AxisVector quantum{};               // m or rad per encoder count
  unsigned transport_delay_ticks{1};  // from a sample to the effort that answers it, beyond the sample-and-hold
};

std::span<const DeviceProfile> all_profiles() noexcept;

// Null for a name that is none.
const DeviceProfile* find_profile(std::string_view name) noexcept;

// What the profile's firmware is configured with. `period_us` is the control period.
firmware::Config firmware_config(const DeviceProfile& profile, std::uint32_t period_us) noexcept;

}  // namespace tactus::hal
