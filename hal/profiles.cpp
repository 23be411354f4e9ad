#include "hal/profiles.h"

namespace tactus::hal {
namespace {

// Both ends know the limit; the host's acts first. 1 % lets a wrench at the limit through in spite of rounding.
constexpr double kFirmwareMargin = 1.01;
// A wrist's three efforts for a torque M have a norm of at most M sqrt(1 + sin pitch): not orthogonal axes.
constexpr double kWristNorm = 1.41;
// The host's guard refuses samples faster than 1.5 times the device's speed; the firmware brakes only beyond that.
constexpr double kOverspeedMargin = 2.0;

constexpr AxisVector per_axis(double translation, double rotation) noexcept {
  return {translation, translation, translation, rotation, rotation, rotation};
}

// The class of the Virtuose 6D35-45: 35 N and 3 N m peak, 10 N and 1 N m continuous, a workspace 0.45 m across.
// Everything else is an estimate for an arm of this size: apparent mass and inertia, damping, friction, encoder quanta,
// speeds, what shorted motors brake with.
constexpr DeviceProfile make_virtuose6d() noexcept {
  DeviceProfile p;
  p.name = "virtuose6d";
  p.properties = {.has_rotation = true,
                  .workspace_radius_m = 0.225,
                  .max_speed_m_per_s = 1.0,
                  .max_angular_speed_rad_per_s = 10.0,
                  .max_force_N = 35.0,
                  .max_torque_Nm = 3.0,
                  .continuous_force_N = 10.0,
                  .continuous_torque_Nm = 1.0,
                  .position_quantum_m = 1e-5,
                  .rotation_quantum_rad = 1e-4,
                  .mass_kg = 0.3,
                  .damping_Ns_per_m = 0.5,
                  .inertia_kg_m2 = 1e-3,
                  .damping_Nms_per_rad = 2e-3,
                  .delay_s = 1e-3};
  p.plant = {.mass_kg = 0.3,
             .inertia_kg_m2 = 1e-3,
             .damping_Ns_per_m = 0.5,
             .damping_Nms_per_rad = 2e-3,
             .coulomb_force_N = 0.2,
             .coulomb_torque_Nm = 5e-3,
             .brake_damping_Ns_per_m = 20.0,
             .brake_damping_Nms_per_rad = 0.05,
             .stop_radius_m = 0.225,
             .max_effort = per_axis(35.0, 3.0),
             .has_rotation = true};
  p.quantum = per_axis(1e-5, 1e-4);
  return p;
}

// The class of a desktop device with three degrees of freedom: 8 N peak, a workspace 0.16 m across.
// Everything else is an estimate, continuous force included.
constexpr DeviceProfile make_desk3d() noexcept {
  DeviceProfile p;
  p.name = "desk3d";
  p.properties = {.has_rotation = false,
                  .workspace_radius_m = 0.08,
                  .max_speed_m_per_s = 1.0,
                  .max_angular_speed_rad_per_s = 10.0,
                  .max_force_N = 8.0,
                  .max_torque_Nm = 0.0,
                  .continuous_force_N = 3.0,
                  .continuous_torque_Nm = 0.0,
                  .position_quantum_m = 2e-5,
                  .rotation_quantum_rad = 1e-4,
                  .mass_kg = 0.2,
                  .damping_Ns_per_m = 0.5,
                  .inertia_kg_m2 = 1e-3,
                  .damping_Nms_per_rad = 2e-3,
                  .delay_s = 1e-3};
  p.plant = {.mass_kg = 0.2,
             .inertia_kg_m2 = 1e-3,
             .damping_Ns_per_m = 0.5,
             .damping_Nms_per_rad = 2e-3,
             .coulomb_force_N = 0.1,
             .coulomb_torque_Nm = 0.0,
             .brake_damping_Ns_per_m = 10.0,
             .brake_damping_Nms_per_rad = 0.0,
             .stop_radius_m = 0.08,
             .max_effort = per_axis(8.0, 0.0),
             .has_rotation = false};
  p.quantum = per_axis(2e-5, 1e-4);
  return p;
}

constexpr std::array<DeviceProfile, 2> kProfiles{make_virtuose6d(), make_desk3d()};

}  // namespace

std::span<const DeviceProfile> all_profiles() noexcept { return kProfiles; }

const DeviceProfile* find_profile(std::string_view name) noexcept {
  for (const DeviceProfile& profile : kProfiles)
    if (profile.name == name) return &profile;
  return nullptr;
}

firmware::Config firmware_config(const DeviceProfile& profile, std::uint32_t period_us) noexcept {
  const haptics::DeviceProperties& p = profile.properties;
  firmware::Config config;
  for (unsigned i = 0; i < kAxisCount; ++i) {
    config.quantum[i] = static_cast<float>(profile.quantum[i]);
    config.max_effort[i] = static_cast<float>(kFirmwareMargin * profile.plant.max_effort[i]);
    const double max_speed = i < 3 ? p.max_speed_m_per_s : p.max_angular_speed_rad_per_s;
    config.max_speed[i] = static_cast<float>(kOverspeedMargin * max_speed);
  }
  config.max_force_N = static_cast<float>(kFirmwareMargin * p.max_force_N);
  config.max_torque_Nm = static_cast<float>(kFirmwareMargin * kWristNorm * p.max_torque_Nm);
  config.period_us = period_us;
  return config;
}

}  // namespace tactus::hal
