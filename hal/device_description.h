// A device as its maker describes it: the figures that somebody measured, estimated or read in a data sheet, each once.
// Everything else that the program must know of a device follows from them (make_profile in profiles.h).
//
// The files in hal/devices/ hold exactly these figures, under the same names. Frame: the device's, with the tool's
// centre pose at its origin. Units: SI. Thread: [setup].
#pragma once

#include <string>

#include "hal/kinematics/kinematics.h"
#include "rt/base/result.h"

namespace tactus::hal {

enum class KinematicsKind : unsigned {
  kStage = 0,      // CartesianStage: 3 prismatic axes, wrist
  kPointArm = 1,   // PointArm: 3 rotary axes, no rotation of the tool
  kWristedArm = 2  // WristedArm: 6 rotary axes
};

struct DeviceDescription {
  std::string name;
  KinematicsKind kind{KinematicsKind::kWristedArm};
  ArmLinks links;  // of an arm

  double workspace_radius_m{0};  // the mechanical stop, about the centre
  double max_speed_m_per_s{0}, max_angular_speed_rad_per_s{10};
  // At the tool, everywhere in the workspace; torques are 0 without a wrist.
  double peak_force_N{0}, peak_torque_Nm{0};
  double continuous_force_N{0}, continuous_torque_Nm{0};
  // As felt at the tool: isotropic, gravity balanced. Without a wrist nothing looks at what rotation is like.
  double mass_kg{0}, inertia_kg_m2{1e-3};
  double damping_Ns_per_m{0}, damping_Nms_per_rad{2e-3};
  double coulomb_friction_N{0}, coulomb_friction_Nm{0};
  double brake_damping_Ns_per_m{0}, brake_damping_Nms_per_rad{0};  // more, while the motors are shorted

  // Encoder counts per metre of a prismatic axis, per turn of a rotary one; 0 for an axis that is not there.
  AxisVector counts_per_m{}, counts_per_turn{};
  unsigned transport_delay_ticks{1};  // from a sample to the effort that answers it, beyond the sample-and-hold

  std::string usb_serial;  // of the one device that is meant; empty: any
  unsigned can_node{1};

  bool has_rotation() const noexcept { return kind != KinematicsKind::kPointArm; }
  friend bool operator==(const DeviceDescription&, const DeviceDescription&) = default;
};

inline constexpr unsigned kMaxCanNode = 63, kMaxDeviceDelayTicks = 32;

// The largest workspace about an arm's rest pose that keeps away from where its inverses are bounded.
double largest_workspace_m(const ArmLinks& links) noexcept;

// Axes that a kind has: the first of them prismatic, the others rotary.
struct AxisKinds {
  unsigned prismatic{0}, rotary{0};
};
AxisKinds axes_of(KinematicsKind kind) noexcept;

// The first figure that cannot go with the others, by its key in a file, and what is accepted. Ranges of single figures
// are the reader's.
struct DescriptionMistake {
  const char* table{nullptr};  // of the file; null: there is no mistake
  const char* key{nullptr};
  std::string what, accepted;
};
DescriptionMistake find_mistake(const DeviceDescription& description);

}  // namespace tactus::hal
