// The damping that drives make at the tool: D = J^-T diag(d) J^-1, with d the damping of each axis.
//
// A drive closes its damping at 10 to 40 kHz, so the gain check may count it as physical damping. What counts is the
// least damping over all directions and the sampled workspace. Units: SI. Thread: [setup].
#pragma once

#include "hal/device_description.h"
#include "hal/kinematics/kinematics.h"

namespace tactus::hal {

struct ToolDamping {
  double translation_Ns_per_m{0}, rotation_Nms_per_rad{0};
};

// Damping of each axis by its drive while there is force: N s/m or N m s/rad.
AxisVector axis_damping(const DriveDescription& drives) noexcept;

// Zero for an axis without damping that the tool can move along.
ToolDamping least_tool_damping(const Kinematics& kinematics, const AxisVector& axis_damping, double workspace_radius_m,
                               bool has_rotation) noexcept;

}  // namespace tactus::hal
