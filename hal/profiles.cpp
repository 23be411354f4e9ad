#include "hal/profiles.h"

#include <array>

#include "hal/drives/drive_damping.h"

namespace tactus::hal {
namespace {

// The wrist's axes are not orthogonal: its three efforts for a torque M have a norm of at most M sqrt(1 + sin pitch).
constexpr double kWristNorm = 1.41;
// The host's guard rejects samples faster than 1.5 times the device's maximum speed; the firmware brakes only beyond
// that. At 60 degrees of pitch the wrist's yaw and roll axes turn twice as fast as the tool, which is still accepted.
constexpr double kOverspeedMargin = 2.0;
// Figures of missing axes stay 0, except the quantum and the speed limit, which the firmware requires to be positive.
constexpr double kUnusedQuantum = 1e-4, kUnusedSpeed = 1.0;

// The class of the Virtuose 6D35-45: 35 N and 3 N m peak, 10 N and 1 N m continuous, a workspace 0.45 m across.
// Everything else is an estimate for an arm of this size: links, apparent mass and inertia, damping, friction,
// encoders, speeds, damping of the shorted motors. The encoders resolve 1e-5 m and 1e-4 rad at the centre.
DeviceDescription make_virtuose6d() {
  DeviceDescription d;
  d.name = "virtuose6d";
  d.kind = KinematicsKind::kWristedArm;
  d.links = {.upper_m = 0.45, .forearm_m = 0.45};
  d.workspace_radius_m = 0.225;
  d.max_speed_m_per_s = 1.0;
  d.max_angular_speed_rad_per_s = 10.0;
  d.peak_force_N = 35.0;
  d.peak_torque_Nm = 3.0;
  d.continuous_force_N = 10.0;
  d.continuous_torque_Nm = 1.0;
  d.mass_kg = 0.3;
  d.inertia_kg_m2 = 1e-3;
  d.damping_Ns_per_m = 0.5;
  d.damping_Nms_per_rad = 2e-3;
  d.coulomb_friction_N = 0.2;
  d.coulomb_friction_Nm = 5e-3;
  d.brake_damping_Ns_per_m = 20.0;
  d.brake_damping_Nms_per_rad = 0.05;
  d.counts_per_turn = {262144, 262144, 262144, 65536, 65536, 65536};
  return d;
}

// The class of a desktop device with three degrees of freedom: 8 N peak, a workspace 0.16 m across.
// Everything else is an estimate, continuous force included. The encoders resolve 2e-5 m at the centre.
DeviceDescription make_desk3d() {
  DeviceDescription d;
  d.name = "desk3d";
  d.kind = KinematicsKind::kPointArm;
  d.links = {.upper_m = 0.16, .forearm_m = 0.16};
  d.workspace_radius_m = 0.08;
  d.max_speed_m_per_s = 1.0;
  d.peak_force_N = 8.0;
  d.continuous_force_N = 3.0;
  d.mass_kg = 0.2;
  d.damping_Ns_per_m = 0.5;
  d.coulomb_friction_N = 0.1;
  d.brake_damping_Ns_per_m = 10.0;
  d.counts_per_turn = {50000, 50000, 50000, 0, 0, 0};
  return d;
}

Kinematics kinematics_of(const DeviceDescription& d) noexcept {
  switch (d.kind) {
    case KinematicsKind::kWristedArm:
      return WristedArm(d.links);
    case KinematicsKind::kPointArm:
      return PointArm(d.links);
    default:
      return CartesianStage();
  }
}

AxisVector quantum_of(const DeviceDescription& d) noexcept {
  AxisVector quantum;
  for (unsigned i = 0; i < kAxisCount; ++i)
    quantum[i] = d.counts_per_m[i] > 0      ? 1.0 / d.counts_per_m[i]
                 : d.counts_per_turn[i] > 0 ? kTurn_rad / d.counts_per_turn[i]
                                            : kUnusedQuantum;
  return quantum;
}

void add_drive_damping(DeviceProfile& p) noexcept {
  const DeviceDescription& d = p.description;
  const ToolDamping least =
      least_tool_damping(p.kinematics, axis_damping(d.drives), d.workspace_radius_m, d.has_rotation());
  p.drive_damping_Ns_per_m = least.translation_Ns_per_m;
  p.drive_damping_Nms_per_rad = least.rotation_Nms_per_rad;
  p.properties.damping_Ns_per_m += least.translation_Ns_per_m;
  p.properties.damping_Nms_per_rad += least.rotation_Nms_per_rad;
}

struct BuiltIn {
  std::array<DeviceDescription, 2> descriptions{make_virtuose6d(), make_desk3d()};
  std::array<DeviceProfile, 2> profiles{make_profile(descriptions[0]), make_profile(descriptions[1])};
};

const BuiltIn& built_in() noexcept {
  static const BuiltIn made;
  return made;
}

}  // namespace

DeviceProfile make_profile(const DeviceDescription& d) {
  DeviceProfile p;
  p.description = d;
  p.name = d.name;
  p.transport_delay_ticks = d.transport_delay_ticks;
  p.kinematics = kinematics_of(d);
  p.quantum = quantum_of(d);
  p.bounds = bounds_over(p.kinematics, p.quantum,
                         {.workspace_radius_m = d.workspace_radius_m,
                          .force_N = d.peak_force_N,
                          .torque_Nm = d.peak_torque_Nm,
                          .speed_m_per_s = d.max_speed_m_per_s,
                          .angular_speed_rad_per_s = d.max_angular_speed_rad_per_s});
  p.properties = {.has_rotation = d.has_rotation(),
                  .workspace_radius_m = d.workspace_radius_m,
                  .max_speed_m_per_s = d.max_speed_m_per_s,
                  .max_angular_speed_rad_per_s = d.max_angular_speed_rad_per_s,
                  .max_force_N = d.peak_force_N,
                  .max_torque_Nm = d.peak_torque_Nm,
                  .continuous_force_N = d.continuous_force_N,
                  .continuous_torque_Nm = d.continuous_torque_Nm,
                  .position_quantum_m = p.bounds.position_quantum_m,
                  .rotation_quantum_rad = p.bounds.rotation_quantum_rad,
                  .mass_kg = d.mass_kg,
                  .damping_Ns_per_m = d.damping_Ns_per_m,
                  .inertia_kg_m2 = d.inertia_kg_m2,
                  .damping_Nms_per_rad = d.damping_Nms_per_rad,
                  .coulomb_friction_N = d.coulomb_friction_N,
                  .coulomb_friction_Nm = d.coulomb_friction_Nm};
  if (!d.has_rotation()) p.properties.rotation_quantum_rad = kUnusedQuantum;
  p.plant = {.mass_kg = d.plant.mass_kg.value_or(d.mass_kg),
             .inertia_kg_m2 = d.plant.inertia_kg_m2.value_or(d.inertia_kg_m2),
             .damping_Ns_per_m = d.plant.damping_Ns_per_m.value_or(d.damping_Ns_per_m),
             .damping_Nms_per_rad = d.plant.damping_Nms_per_rad.value_or(d.damping_Nms_per_rad),
             .coulomb_force_N = d.plant.coulomb_friction_N.value_or(d.coulomb_friction_N),
             .coulomb_torque_Nm = d.plant.coulomb_friction_Nm.value_or(d.coulomb_friction_Nm),
             .brake_damping_Ns_per_m = d.brake_damping_Ns_per_m,
             .brake_damping_Nms_per_rad = d.brake_damping_Nms_per_rad,
             .stop_radius_m = d.plant.stop_radius_m.value_or(d.workspace_radius_m),
             .max_effort = p.bounds.effort,
             .has_rotation = d.has_rotation()};
  if (!d.drives.empty()) add_drive_damping(p);
  return p;
}

std::span<const DeviceDescription> built_in_descriptions() noexcept { return built_in().descriptions; }

std::span<const DeviceProfile> all_profiles() noexcept { return built_in().profiles; }

const DeviceProfile* find_profile(std::string_view name) noexcept {
  for (const DeviceProfile& profile : all_profiles())
    if (profile.name == name) return &profile;
  return nullptr;
}

firmware::Config firmware_config(const DeviceProfile& profile, std::uint32_t period_us) noexcept {
  firmware::Config config;
  for (unsigned i = 0; i < kAxisCount; ++i) {
    const double speed = kOverspeedMargin * profile.bounds.rate[i];
    config.quantum[i] = static_cast<float>(profile.quantum[i]);
    config.max_effort[i] = static_cast<float>(kFirmwareMargin * profile.plant.max_effort[i]);
    config.max_speed[i] = static_cast<float>(speed > 0 ? speed : kUnusedSpeed);
  }
  config.max_force_N = static_cast<float>(kFirmwareMargin * profile.bounds.arm_effort_norm);
  config.max_torque_Nm = static_cast<float>(kFirmwareMargin * kWristNorm * profile.properties.max_torque_Nm);
  config.period_us = period_us;
  return config;
}

}  // namespace tactus::hal
