// Planes in place of a world: what the haptic side feels of the proxy's contacts until the next snapshot.
//
// Each contact point of the proxy is a plane that its position may not cross. The proxy has no mass: it is as near to
// where the device wants it as the planes allow, and the coupling's spring and damper pull between the two. Planes
// stand still and have no friction; the proxy turns as the device does. Linearised, they hold from both sides: the
// force is F0 + J (x - x0) with J = -K times the projection on the contacts' normals, so it pulls where the hand
// withdraws. Thread: [rt]. Frame: world. Units: SI. Bound: kMaxProxyPlanes planes, kPlaneSweeps sweeps over them.
// Source: a plane: Adachi, Kumano, Ogino 1995; a set of planes: Ruspini, Kolarov, Khatib 1997 for the proxy; the
// Jacobian of the force: the paper's introduction, [4]. The nearest point by sweeps: Hildreth 1957.
#pragma once

#include <span>

#include "rt/base/bounded_vector.h"
#include "rt/haptics/coupling_scheme.h"
#include "rt/physics/border/border_contact.h"

namespace tactus::haptics {

inline constexpr std::uint32_t kMaxProxyPlanes = 16;
inline constexpr unsigned kPlaneSweeps = 24;

// The proxy's position x, its orientation being the device's, has normal . x >= offset.
struct ProxyPlane {
  Vec3d normal;      // unit, away from what is touched
  double offset{0};  // m
};
using ProxyPlanes = FixedVector<ProxyPlane, kMaxProxyPlanes>;

// Of the proxy's contacts as the last snapshot has them; linearised, of those that pressed.
ProxyPlanes planes_of(std::span<const physics::BorderContact<double>> contacts, const Quatd& rotation,
                      CouplingScheme scheme) noexcept;

struct HeldProxy {
  Vec3d position, velocity;  // m, m/s
  bool touches{false};
};

// The nearest to `wanted` above all planes, which the velocity does not cross either.
HeldProxy keep_above(std::span<const ProxyPlane> planes, const Vec3d& wanted, const Vec3d& velocity) noexcept;
// The nearest on all planes.
HeldProxy keep_on(std::span<const ProxyPlane> planes, const Vec3d& wanted, const Vec3d& velocity) noexcept;

}  // namespace tactus::haptics
