// The border as the haptic side has it: the border contacts and ghosts of a snapshot, in the members' world.
//
// All border contacts are new at a synchronisation, the friction point too; one that was there before keeps the
// impulses that start the solver. Within a cycle they are the world's to solve (rt/physics/border). While the global
// world is late, what moves outside slows down. Thread: construction [setup]; the rest [rt], the haptic thread. Frame:
// world. Units: SI. Bound: as many contacts as the world holds, each sought among kSearchWindow of the former ones.
// Source: the paper, section 2.2.
#pragma once

#include "rt/haptics/coupling/snapshot.h"
#include "rt/haptics/coupling/world_lateness.h"

namespace tactus::haptics {

class BorderImport {
 public:
  explicit BorderImport(std::uint32_t border_contacts)
      : outside_velocity_(border_contacts), replaced_(border_contacts) {}

  // At a synchronisation, after the members have changed.
  void renew(const WorldSnapshot& snapshot, const physics::BorderTraits& traits, physics::World& world) noexcept;
  // Once a tick.
  void slow_down(const WorldLateness& late, physics::World& world) const noexcept;

  void save(ByteWriter& out) const noexcept;
  [[nodiscard]] bool restore(ByteReader& in, const physics::World& world) noexcept;
  std::size_t save_size_bound() const noexcept {
    return sizeof(std::uint32_t) + outside_velocity_.capacity() * sizeof(Vec3d);
  }

 private:
  BoundedVector<Vec3d> outside_velocity_;           // per border contact, as adopted
  BoundedVector<physics::BorderContact> replaced_;  // scratch of renew
};

}  // namespace tactus::haptics
