// The kinematics that a device description names: one of the implemented kinds, chosen at set-up.
// Frame: the device's. Units: SI. Thread: [any]; no allocation, no virtual call, bounded.
#pragma once

#include <variant>

#include "hal/kinematics/arm.h"
#include "hal/kinematics/cartesian_stage.h"

namespace tactus::hal {

class Kinematics {
  std::variant<CartesianStage, PointArm, WristedArm> kind_;

  // Instead of std::visit, which may throw (valueless variant); these types cannot become valueless.
  template <class F>
  auto call(F&& function) const noexcept {
    if (const auto* arm = std::get_if<WristedArm>(&kind_)) return function(*arm);
    if (const auto* arm = std::get_if<PointArm>(&kind_)) return function(*arm);
    return function(*std::get_if<CartesianStage>(&kind_));
  }

 public:
  Kinematics() noexcept = default;                                    // the stage
  Kinematics(const CartesianStage& stage) noexcept : kind_(stage) {}  // NOLINT(google-explicit-constructor)
  Kinematics(const PointArm& arm) noexcept : kind_(arm) {}            // NOLINT(google-explicit-constructor)
  Kinematics(const WristedArm& arm) noexcept : kind_(arm) {}          // NOLINT(google-explicit-constructor)

  Posed pose_of(const AxisVector& q) const noexcept {
    return call([&](const auto& k) noexcept { return k.pose_of(q); });
  }
  Twistd twist_of(const AxisVector& q, const AxisVector& rate) const noexcept {
    return call([&](const auto& k) noexcept { return k.twist_of(q, rate); });
  }
  AxisVector rates_of(const AxisVector& q, const Twistd& twist) const noexcept {
    return call([&](const auto& k) noexcept { return k.rates_of(q, twist); });
  }
  AxisVector efforts_of(const AxisVector& q, const Wrenchd& wrench) const noexcept {
    return call([&](const auto& k) noexcept { return k.efforts_of(q, wrench); });
  }
  Wrenchd wrench_of(const AxisVector& q, const AxisVector& effort) const noexcept {
    return call([&](const auto& k) noexcept { return k.wrench_of(q, effort); });
  }
};

static_assert(ToolKinematics<Kinematics>);
static_assert(std::is_trivially_copyable_v<Kinematics>);

}  // namespace tactus::hal
