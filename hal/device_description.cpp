#include "hal/device_description.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tactus::hal {
namespace {

DescriptionMistake above(const char* key, double value, double peak) {
  return {.table = "limits",
          .key = key,
          .what = fmt::format("{:g} is above the peak", value),
          .accepted = fmt::format("at most {:g}", peak)};
}

}  // namespace

double largest_workspace_m(const ArmLinks& links) noexcept {
  // Squared distance of the tool from the shoulder: d^2 = a^2 + b^2 + 2 a b sin(e), with |cos(e)| >= kCosPitchLimit.
  const double a = links.upper_m, b = links.forearm_m, squares = a * a + b * b;
  const double sine = std::sqrt(1.0 - kCosPitchLimit * kCosPitchLimit), centre = std::sqrt(squares);
  const double outwards = std::sqrt(squares + 2.0 * a * b * sine) - centre;
  const double inwards = centre - std::sqrt(squares - 2.0 * a * b * sine);
  return std::min({outwards, inwards, 0.9 * b});
}

AxisKinds axes_of(KinematicsKind kind) noexcept {
  switch (kind) {
    case KinematicsKind::kStage:
      return {3, 3};
    case KinematicsKind::kPointArm:
      return {0, 3};
    default:
      return {0, 6};
  }
}

DescriptionMistake find_mistake(const DeviceDescription& d) {
  const double largest = largest_workspace_m(d.links);
  if (d.kind != KinematicsKind::kStage && d.workspace_radius_m > largest)
    return {.table = "workspace",
            .key = "radius_m",
            .what = fmt::format("{:g} is more than the links reach freely", d.workspace_radius_m),
            .accepted = fmt::format("at most {:g}, or longer links", largest)};
  if (d.continuous_force_N > d.peak_force_N) return above("continuous_force_N", d.continuous_force_N, d.peak_force_N);
  if (d.continuous_torque_Nm > d.peak_torque_Nm)
    return above("continuous_torque_Nm", d.continuous_torque_Nm, d.peak_torque_Nm);
  if (!d.has_rotation() && d.peak_torque_Nm > 0)
    return {.table = "limits",
            .key = "peak_torque_Nm",
            .what = "set, but a point_arm takes no torque",
            .accepted = "0, or another kinematics kind"};
  return {};
}

}  // namespace tactus::hal
