// The plane couplings: planes replace the proxy's contacts on the haptic side until the next snapshot.
//
// Each contact point of the proxy is a plane that limits its position; the proxy has no mass and takes the device's
// rotation. The coupling's spring and damper pull it to the device, and the planes with their friction cones constrain
// it (plane_projection.h). The force on a plane, damper included, is in its cone in every tick, so a proxy sticks below
// the contact's coefficient of friction and slides above it. A sticking point moves with the velocity that the touched
// surface had in the last global step; with a late world surfaces are at rest.
// Along their normals planes do not move within a cycle. New planes replace the old ones over the ticks of a cycle, by
// a weighted mean of the two forces: while the hand does not move, a tick changes the force by at most 1/ratio of the
// difference. So the force has no step where a plane appears, vanishes or moves, and never pulls where neither set of
// planes would. The price is a delay of half a cycle in the response of the global world.
// Linearised: planes are bilateral. The force is F0 + J (x - x0) with J = -K times the projection on the contacts'
// normals, so it pulls when the hand withdraws; tangentially J is -K while friction holds.
// Thread: [rt], the haptic thread. Frame: world. Units: SI. Bound: kMaxProxyPlanes contact points, the first ones of
// the snapshot; constant time. Raises no status.
// Source: a plane: Adachi, Kumano, Ogino 1995; its friction, and new planes brought in over a recovery time so that the
// force has no step: Mark, Randolph, Finch, Van Verth, Taylor 1996; a set of planes: Ruspini, Kolarov, Khatib 1997; a
// local model of a slow simulation: Barbagli, Prattichizzo, Salisbury 2003; with the Jacobian of the force: Cavusoglu,
// Tendick 2000.
#pragma once

#include <span>

#include "rt/base/bytes.h"
#include "rt/haptics/coupling/plane_projection.h"
#include "rt/haptics/coupling/snapshot.h"

namespace tactus::haptics {

class PlaneCoupling {
 public:
  struct Tick {
    bool planes_hold{false};  // CouplingTraits
    double period_s{1e-3};
    std::uint32_t in_cycle{0}, ratio{1};  // index of the tick in its cycle, from 0; ticks per cycle
    double lead_s{0};                     // CouplingGains::lead_s: damping / stiffness
  };

  // Call at a synchronisation, with the proxy's contacts from the snapshot.
  void adopt(std::span<const physics::BorderContact> contacts) noexcept;
  // Call before the first adopt(), also that of a new epoch: no former planes, friction holds the proxy at `proxy` [m].
  void start(const Vec3d& proxy) noexcept;
  // Call once a tick while the device is engaged. Returns the proxy's motion; the force is that of the spring and
  // damper between it and the device.
  HeldProxy follow(const DeviceTarget& target, const Tick& tick) noexcept;
  // Call while the device is not engaged: resets the friction points.
  void let_go() noexcept { follows_ = 0; }

  void save(ByteWriter& out) const noexcept;
  [[nodiscard]] bool restore(ByteReader& in) noexcept;

 private:
  struct ContactPlane {
    Vec3d normal;            // unit, away from the touched body
    Vec3d anchor;            // m, proxy frame: the contact point
    double height{0};        // m: offset of the surface along the normal
    double friction{0};      // coefficient
    double press_N{0};       // normal force in the last global step
    Vec3d surface_velocity;  // m/s
  };
  struct PlaneSet {
    FixedVector<ContactPlane, kMaxProxyPlanes> planes;
    Vec3d held;  // m: position that these planes allowed in the last tick
  };

  static HeldProxy keep(PlaneSet& set, const DeviceTarget& target, const Tick& tick) noexcept;

  PlaneSet now_, before_;  // of the last snapshot; of the one before it
  Vec3d held_;             // m: blended position of the last tick
  std::uint32_t follows_{0};

 public:
  static constexpr std::size_t kMaxBytes =
      2 * (sizeof(std::uint32_t) + kMaxProxyPlanes * sizeof(ContactPlane) + sizeof(Vec3d)) + sizeof(Vec3d) +
      sizeof(std::uint32_t);
};

}  // namespace tactus::haptics
