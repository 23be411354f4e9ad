// Projects a massless point, pulled to a wanted position, onto the region that planes with friction allow.
//
// Normal direction: each plane applies the correction that keeps the point on its side (nearest point). Tangential
// direction: it applies the correction that keeps the point at its friction point, but at most the friction coefficient
// times the normal correction: the friction cone. So a point pulled outside of the cone slides to its edge, and the
// correction of a plane is always in its cone. Several planes are projected one by one, repeatedly: without friction
// this converges to the nearest point, with friction near a point whose corrections are in all cones.
// Thread: [rt], pure. Frame: world. Units: SI. Bound: kMaxProxyPlanes planes, kPlaneSweeps sweeps over them.
// Source: the massless point: Zilles, Salisbury 1995 (god-object), Ruspini, Kolarov, Khatib 1997 (proxy); its friction
// cone: Salisbury, Brock, Massie, Swarup, Zilles 1995, Harwin, Melder 2002; the sweeps: Hildreth 1957.
#pragma once

#include <span>

#include "rt/base/bounded_vector.h"
#include "rt/base/spatial.h"

namespace tactus::haptics {

inline constexpr std::uint32_t kMaxProxyPlanes = 16;
inline constexpr unsigned kPlaneSweeps = 24;

// Constraint on the point x: normal . x >= offset.
struct ProxyPlane {
  Vec3d normal;              // unit, away from the touched body
  double offset{0};          // m
  double friction{0};        // coefficient
  Vec3d hold{};              // m: friction point; its component along the normal has no effect
  Vec3d surface_velocity{};  // m/s, of the touched surface: a sticking point moves with it
};
using ProxyPlanes = FixedVector<ProxyPlane, kMaxProxyPlanes>;

struct HeldProxy {
  Vec3d position, velocity;  // m, m/s
  bool touches{false};       // a plane applies a correction
  bool slides{false};        // the correction of a plane with friction is at the edge of its cone
};

// Unilateral planes. The velocity result is `velocity` minus what the planes stop.
HeldProxy keep_above(std::span<const ProxyPlane> planes, const Vec3d& wanted, const Vec3d& velocity) noexcept;
// Bilateral planes. Friction only where the normal correction pushes.
HeldProxy keep_on(std::span<const ProxyPlane> planes, const Vec3d& wanted, const Vec3d& velocity) noexcept;

}  // namespace tactus::haptics
