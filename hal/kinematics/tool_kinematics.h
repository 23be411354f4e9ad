// Concept for a device's kinematics: tool pose and twist from the axes, axis efforts from a tool wrench, and inverses.
//
// A device with a new mechanism supplies these five functions; the rest of hal/ does not change. Prismatic axes use m,
// m/s and N, rotary axes rad, rad/s and N m.
// Efforts do the same work as the wrench: effort . rate = wrench . twist (transpose of the Jacobian, exact).
// Frame: the device's; the tool's centre pose is its origin. Units: SI. Thread: [any]; pure functions, no allocation,
// bounded. Bound: near a singularity an inverse is bounded (finite, no longer exact), because received counts may have
// any value; each class states where.
#pragma once

#include <array>
#include <concepts>

#include "rt/base/spatial.h"

namespace tactus::hal {

inline constexpr unsigned kAxisCount = 6;
using AxisVector = std::array<double, kAxisCount>;  // m and rad, their rates, or N and N m

// A device with fewer axes leaves the last ones unused: they move nothing and get no effort.
template <class K>
concept ToolKinematics = requires(const K kinematics, const AxisVector& q, const Wrenchd& wrench, const Twistd& twist) {
  { kinematics.pose_of(q) }
  noexcept->std::same_as<Posed>;  // device_from_tool
  { kinematics.twist_of(q, q) }
  noexcept->std::same_as<Twistd>;  // J(q) rate
  { kinematics.rates_of(q, twist) }
  noexcept->std::same_as<AxisVector>;  // J(q)^-1 twist
  { kinematics.efforts_of(q, wrench) }
  noexcept->std::same_as<AxisVector>;  // J(q)^T wrench
  { kinematics.wrench_of(q, q) }
  noexcept->std::same_as<Wrenchd>;  // J(q)^-T efforts
};

constexpr AxisVector unit_axis(unsigned axis) noexcept {
  AxisVector unit{};
  unit[axis] = 1.0;
  return unit;
}

}  // namespace tactus::hal
