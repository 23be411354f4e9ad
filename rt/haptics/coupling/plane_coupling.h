// Planes in place of a world: what the haptic side feels of the proxy's contacts until the next snapshot.
//
// Each contact point of the proxy is a plane that its position may not cross; the proxy has no mass and turns as the
// device does. The coupling's spring and damper pull it to the device, and the planes let it follow within their
// friction cones (plane_projection.h): the force on a plane is in its cone in every tick, damper included, so a proxy
// holds below the contact's coefficient of friction and slides above. What friction holds goes along with the surface
// that is touched, with its velocity of the last global step; a late world's surfaces stand still.
// Along their normals planes stand still within a cycle. New planes take over from the old ones over the ticks of a
// cycle, as a weighted mean of the two forces: where the hand does not move, a tick changes the force by no more than
// 1/ratio of the difference. So no step is felt where a plane comes, goes or moves, and the force never pulls where
// neither set of planes would. It costs half a cycle of delay in what the global world has to say.
// Linearised, planes hold from both sides: the force is F0 + J (x - x0), with J = -K times the projection on the
// contacts' normals, so it pulls where the hand withdraws; in their planes J is -K while friction holds.
// Thread: [rt], the haptic thread. Frame: world. Units: SI. Bound: kMaxProxyPlanes contact points, those that the
// snapshot lists first; constant time. Raises no status.
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
    std::uint32_t in_cycle{0}, ratio{1};  // the tick's number in its cycle, 0 first; ticks per cycle
    double lead_s{0};                     // the coupling's damping / stiffness
  };

  // At a synchronisation: the proxy's contacts as the snapshot has them.
  void adopt(std::span<const physics::BorderContact> contacts) noexcept;
  // Before the first of them, and of a new epoch: nothing came before, and friction holds the proxy where it is (m).
  void start(const Vec3d& proxy) noexcept;
  // Once a tick, while the device holds the proxy: where it is. The spring and damper between it and the device are
  // then the force.
  HeldProxy follow(const DeviceTarget& target, const Tick& tick) noexcept;
  // The device does not hold the proxy: friction has nothing to hold.
  void let_go() noexcept { follows_ = 0; }

  void save(ByteWriter& out) const noexcept;
  [[nodiscard]] bool restore(ByteReader& in) noexcept;

 private:
  struct ContactPlane {
    Vec3d normal;            // unit, away from what is touched
    Vec3d anchor;            // m, in the proxy's frame: its contact point
    double height{0};        // m: of the surface, along the normal
    double friction{0};      // coefficient
    double press_N{0};       // in the last global step
    Vec3d surface_velocity;  // m/s
  };
  struct PlaneSet {
    FixedVector<ContactPlane, kMaxProxyPlanes> planes;
    Vec3d held;  // m: where they let the proxy be in the last tick
  };

  static HeldProxy keep(PlaneSet& set, const DeviceTarget& target, const Tick& tick) noexcept;

  PlaneSet now_, before_;  // of the last snapshot, of the one before
  Vec3d held_;             // m: where both together let it be in the last tick
  std::uint32_t follows_{0};

 public:
  static constexpr std::size_t kMostBytes =
      2 * (sizeof(std::uint32_t) + kMaxProxyPlanes * sizeof(ContactPlane) + sizeof(Vec3d)) + sizeof(Vec3d) +
      sizeof(std::uint32_t);
};

}  // namespace tactus::haptics
