// Where planes with friction let a point without mass be that is pulled to where it is wanted.
//
// Each plane takes as much of the pull as it needs to keep the point on its side (nearest point), and of the pull along
// itself as much as keeps the point where friction holds it, but no more than the friction coefficient times the
// former: the friction cone. So a point that is pulled outside of the cone slides to its edge, and the pull of a plane
// is in its cone always. With several planes this is repeated plane by plane, which ends at the nearest point for
// planes without friction, and near a point that all cones bear with it.
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

// The point x has normal . x >= offset.
struct ProxyPlane {
  Vec3d normal;              // unit, away from what is touched
  double offset{0};          // m
  double friction{0};        // coefficient
  Vec3d hold{};              // m: where friction holds the point; what of it is along the normal does not matter
  Vec3d surface_velocity{};  // m/s, of what is touched: a point that is held moves with it
};
using ProxyPlanes = FixedVector<ProxyPlane, kMaxProxyPlanes>;

struct HeldProxy {
  Vec3d position, velocity;  // m, m/s
  bool touches{false};       // a plane pulls
  bool slides{false};        // one with friction does, and cannot hold it
};

// Above all planes. Of the velocity what they do not stop is left.
HeldProxy keep_above(std::span<const ProxyPlane> planes, const Vec3d& wanted, const Vec3d& velocity) noexcept;
// On all planes: they hold from both sides. Friction where they push.
HeldProxy keep_on(std::span<const ProxyPlane> planes, const Vec3d& wanted, const Vec3d& velocity) noexcept;

}  // namespace tactus::haptics
