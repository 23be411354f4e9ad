// The description of a device: each figure that was measured, estimated or taken from a data sheet, once. make_profile
// (profiles.h) derives everything else that the program needs.
//
// The files in hal/devices/ contain exactly these figures, under the same names. Frame: the device's, with the tool's
// centre pose at its origin. Units: SI. Thread: [setup].
#pragma once

#include <optional>
#include <string>

#include "hal/drives/drive_axis.h"
#include "hal/kinematics/kinematics.h"
#include "rt/base/result.h"

namespace tactus::hal {

enum class KinematicsKind : unsigned {
  kStage = 0,      // CartesianStage: 3 prismatic axes, wrist
  kPointArm = 1,   // PointArm: 3 rotary axes, no rotation of the tool
  kWristedArm = 2  // WristedArm: 6 rotary axes
};

// The mechanics that `--device sim` simulates, at the tool. What is left out is taken from [mechanics] and [workspace]:
// the simulated arm is then exactly the described one. Other figures make the description wrong, to see what follows.
struct PlantFigures {
  std::optional<double> mass_kg, inertia_kg_m2;
  std::optional<double> damping_Ns_per_m, damping_Nms_per_rad;
  std::optional<double> coulomb_friction_N, coulomb_friction_Nm;
  std::optional<double> stop_radius_m;  // of the mechanical stop about the centre; default: the workspace's radius
  friend bool operator==(const PlantFigures&, const PlantFigures&) = default;
};

struct DeviceDescription {
  std::string name;
  KinematicsKind kind{KinematicsKind::kWristedArm};
  ArmLinks links;  // of an arm

  double workspace_radius_m{0};  // distance of the mechanical stop from the centre
  double max_speed_m_per_s{0}, max_angular_speed_rad_per_s{10};
  // At the tool, everywhere in the workspace; torques are 0 without a wrist.
  double peak_force_N{0}, peak_torque_Nm{0};
  double continuous_force_N{0}, continuous_torque_Nm{0};
  // Apparent at the tool: isotropic, gravity balanced. Without a wrist the rotary figures are not used.
  double mass_kg{0}, inertia_kg_m2{1e-3};
  double damping_Ns_per_m{0}, damping_Nms_per_rad{2e-3};
  double coulomb_friction_N{0}, coulomb_friction_Nm{0};
  double brake_damping_Ns_per_m{0}, brake_damping_Nms_per_rad{0};  // added while the motors are shorted

  PlantFigures plant;

  // Encoder counts per metre of a prismatic axis, per turn of a rotary axis; 0 for a missing axis.
  AxisVector counts_per_m{}, counts_per_turn{};
  unsigned transport_delay_ticks{1};  // from a sample to the effort computed from it, beyond the sample-and-hold

  DriveDescription drives;  // of an arm of CAN drives; empty for a device with tactus' firmware or wire

  std::string usb_serial;  // selects one device; empty: any
  unsigned can_node{1};

  bool has_rotation() const noexcept { return kind != KinematicsKind::kPointArm; }
  friend bool operator==(const DeviceDescription&, const DeviceDescription&) = default;
};

inline constexpr unsigned kMaxDeviceDelayTicks = 32;

// Radius [m] of the largest workspace about an arm's rest pose in which its inverse kinematics is exact (arm.h).
double largest_workspace_m(const ArmLinks& links) noexcept;

// Number of axes of a kind: the prismatic ones come first, then the rotary ones.
struct AxisKinds {
  unsigned prismatic{0}, rotary{0};
};
AxisKinds axes_of(KinematicsKind kind) noexcept;

// The first figure that is inconsistent with the others, by its key in a file, and what is accepted. The file's reader
// checks the ranges of single figures.
struct DescriptionMistake {
  const char* table{nullptr};  // the file's table; null: no mistake
  const char* key{nullptr};
  std::string what, accepted;
};
DescriptionMistake find_mistake(const DeviceDescription& description);

}  // namespace tactus::hal
