// The virtual coupling: a spring and damper between the device and the proxy, in translation and rotation.
//
// Stretch e = device - proxy; twist: the small rotation from the proxy to the device. The wrench on the proxy is K e +
// B (v_device - v_proxy), in translation and in rotation; the device gets the opposite.
// Thread: [any], pure. Frame: world, about the proxy's centre. Units: SI, in the names. Source: Colgate, Stanley, Brown
// 1995.
#pragma once

#include "rt/haptics/coupling/snapshot.h"
#include "rt/physics/pose_spring.h"

namespace tactus::haptics {

struct CouplingGains {
  double stiffness_N_per_m{2000}, damping_Ns_per_m{5};
  double stiffness_Nm_per_rad{5}, damping_Nms_per_rad{0.02};

  // The gains at the hand, where world lengths are `motion_scale` times the device's and power is conserved.
  constexpr CouplingGains at_hand(double motion_scale) const noexcept {
    const double s2 = motion_scale * motion_scale;
    return {.stiffness_N_per_m = s2 * stiffness_N_per_m,
            .damping_Ns_per_m = s2 * damping_Ns_per_m,
            .stiffness_Nm_per_rad = stiffness_Nm_per_rad,
            .damping_Nms_per_rad = damping_Nms_per_rad};
  }
  // Lead of the damper's force over the spring's: B / K [s]; 0 without stiffness.
  constexpr double lead_s() const noexcept {
    return stiffness_N_per_m > 0 ? damping_Ns_per_m / stiffness_N_per_m : 0.0;
  }

  friend constexpr bool operator==(const CouplingGains&, const CouplingGains&) noexcept = default;
};

// Explicit coupling wrench on the proxy [N, N m, world, about its centre], for a proxy whose spring no world solves
// implicitly.
inline Wrenchd coupling_wrench(const CouplingGains& gains, const DeviceTarget& device,
                               const physics::BodyMotion& proxy) noexcept {
  const Vec3d stretch = device.pose.position - proxy.pose.position;
  const Vec3d twist = small_rotation_vector(device.pose.rotation * conjugate(proxy.pose.rotation));
  return {gains.stiffness_N_per_m * stretch + gains.damping_Ns_per_m * (device.velocity.linear - proxy.velocity.linear),
          gains.stiffness_Nm_per_rad * twist +
              gains.damping_Nms_per_rad * (device.velocity.angular - proxy.velocity.angular)};
}

// Sets the spring that the world solves implicitly: from the body in `slot` to the device or, when the device is not
// engaged, a damper that brings the body to rest where it is.
inline void aim_spring(const CouplingGains& gains, const DeviceTarget& device, physics::SlotIndex slot,
                       const Posed& body, physics::PoseSpring& spring) noexcept {
  spring.enabled = true;
  spring.slot = slot;
  spring.stiffness_N_per_m = device.engaged ? gains.stiffness_N_per_m : 0.0;
  spring.stiffness_Nm_per_rad = device.engaged ? gains.stiffness_Nm_per_rad : 0.0;
  spring.damping_Ns_per_m = gains.damping_Ns_per_m;
  spring.damping_Nms_per_rad = gains.damping_Nms_per_rad;
  spring.target = device.engaged ? device.pose : body;
  spring.target_velocity = device.engaged ? device.velocity : Twistd{};
}

}  // namespace tactus::haptics
