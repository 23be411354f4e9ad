// How the haptic side and the global world are coupled: the paper's method, the three it is compared with (paper,
// section 3.3), and three that its introduction cites as intermediate representations. Thread: [any].
#pragma once

#include <cstdint>

namespace tactus::haptics {

enum class CouplingScheme : std::uint32_t {
  kSubWorld = 0,       // members run at the device's rate; the worlds exchange once a cycle
  kDirect = 1,         // the whole world runs at the device's rate; no global world
  kInterpolation = 2,  // the device feels the proxy's positions interpolated between global states; the global step
                       // holds the proxy to the device, see interpolation_coupling.h
  kStatic = 3,         // the proxy moves at the device's rate among members that are frozen; its state is imposed on
                       // the global world at the synchronisation
  // The device feels what the global world makes of the proxy's contacts, see plane_coupling.h; the bodies move in the
  // global world alone, where the proxy's state is imposed and pushed by the force that the hand felt.
  kPlane = 4,       // one plane: the contact that presses most
  kPlanes = 5,      // a plane for each contact point
  kLinearised = 6,  // force and Jacobian of the contacts that press
};

constexpr bool feels_planes(CouplingScheme scheme) noexcept {
  return scheme == CouplingScheme::kPlane || scheme == CouplingScheme::kPlanes || scheme == CouplingScheme::kLinearised;
}

// The device feels the proxy alone: it is the only member.
constexpr bool feels_proxy_alone(CouplingScheme scheme) noexcept {
  return scheme == CouplingScheme::kInterpolation || feels_planes(scheme);
}

}  // namespace tactus::haptics
