// The coupling schemes between the haptic side and the global world: the paper's method, the three it is compared with
// (paper, section 3.3), and three that its introduction cites as intermediate representations.
//
// A scheme is a row of traits: what the haptic side simulates, and how the global world uses its report. The code on
// both sides tests traits and never the scheme. A new scheme is an enumerator, its traits and, where no existing one
// serves, a local model (rt/haptics/README.md, "Add a coupling scheme"). Thread: [any].
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "rt/base/choice.h"
#include "rt/haptics/coupling/plane_projection.h"

namespace tactus::haptics {

enum class CouplingScheme : std::uint32_t {
  kSubWorld = 0,       // members are simulated at the device's rate; the worlds exchange once a cycle
  kDirect = 1,         // the whole world is simulated at the device's rate; no global world
  kInterpolation = 2,  // the proxy shown to the device is interpolated between global states; the global step
                       // couples the proxy to the device, see proxy_interpolation.h
  kStatic = 3,         // the proxy moves at the device's rate among frozen members; its state is imposed on
                       // the global world at the synchronisation
  // The device feels a local model of the proxy's contacts from the last global step, see plane_coupling.h. Only the
  // global world moves bodies; there the proxy's state is imposed and loaded with the force that the hand felt.
  kPlane = 4,       // one plane: at the contact point with the largest normal force
  kPlanes = 5,      // a plane for each contact point
  kLinearised = 6,  // force and Jacobian of the contacts under load
};

// What the haptic side simulates between two synchronisations.
enum class LocalModel : std::uint32_t {
  kMembers,            // a world of members, the proxy on the coupling's spring (sub_world.h)
  kInterpolatedProxy,  // the proxy, interpolated between its last two global states (proxy_interpolation.h)
  kProxyOnPlanes,      // the proxy on planes at its contact points (plane_coupling.h)
};

// How the device loads the proxy in a global step.
enum class DeviceLoad : std::uint32_t {
  kSpring,  // the coupling's spring and damper, solved implicitly with the contacts
  kWrench,  // the mean wrench of the last cycle, extrapolated
};

struct CouplingTraits {
  std::string_view name;  // in options, JSON and tables
  LocalModel model{LocalModel::kMembers};
  bool global_world{true};     // false: the haptic side simulates the whole world
  bool members_frozen{false};  // all members but the proxy stay as in the last snapshot
  bool border{false};          // contacts and joints between members and outside bodies are exchanged
  bool imposes_motion{true};   // the reported members' motion replaces that in the global world
  DeviceLoad device_load{DeviceLoad::kWrench};
  std::uint32_t proxy_planes{0};  // contact points in a snapshot: those of the proxy with the largest normal force
  bool planes_hold{false};        // planes are bilateral: a linearised force

  // The proxy is the only member.
  constexpr bool proxy_alone() const noexcept { return model != LocalModel::kMembers; }
};

// The name is empty for a number that is no scheme.
constexpr CouplingTraits traits_of(CouplingScheme scheme) noexcept {
  using enum CouplingScheme;
  switch (scheme) {
    case kSubWorld:
      return {.name = "sub-world", .border = true, .device_load = DeviceLoad::kSpring};
    case kDirect:
      return {.name = "direct", .global_world = false};
    case kInterpolation:
      return {.name = "interpolation",
              .model = LocalModel::kInterpolatedProxy,
              .imposes_motion = false,
              .device_load = DeviceLoad::kSpring};
    case kStatic:
      return {.name = "static", .members_frozen = true};
    case kPlane:
      return {.name = "plane", .model = LocalModel::kProxyOnPlanes, .proxy_planes = 1};
    case kPlanes:
      return {.name = "planes", .model = LocalModel::kProxyOnPlanes, .proxy_planes = kMaxProxyPlanes};
    case kLinearised:
      return {.name = "linearised",
              .model = LocalModel::kProxyOnPlanes,
              .proxy_planes = kMaxProxyPlanes,
              .planes_hold = true};
  }
  return {};
}

// In the order of help texts and tables.
inline constexpr std::array kCouplingSchemes{
    CouplingScheme::kSubWorld, CouplingScheme::kDirect, CouplingScheme::kInterpolation, CouplingScheme::kStatic,
    CouplingScheme::kPlane,    CouplingScheme::kPlanes, CouplingScheme::kLinearised};
static_assert(lists_every_choice(kCouplingSchemes), "a scheme that has traits is not in the list, or twice");

}  // namespace tactus::haptics
