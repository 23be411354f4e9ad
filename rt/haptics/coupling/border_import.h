// Imports the border of a snapshot, contacts and ghosts, into the members' world.
//
// A synchronisation replaces all border contacts, friction points included. A ghost's contact starts with the impulses
// of the global step (border_correction.h). Any other one, and one that did not press in the global step, keeps those
// that it had before the synchronisation. Within a cycle the world solves the contacts (rt/physics/border). While the
// global world is late, outside bodies slow down. Thread: construction [setup]; the rest [rt], the haptic thread.
// Frame: world. Units: SI. Bound: as many contacts as the world holds; each is looked up among kSearchWindow of the
// former ones. Source: the paper, section 2.2.
#pragma once

#include "rt/haptics/coupling/snapshot.h"
#include "rt/haptics/coupling/world_lateness.h"

namespace tactus::haptics {

class BorderImport {
 public:
  explicit BorderImport(std::uint32_t border_contacts) : outside_velocity_(border_contacts), former_(border_contacts) {}

  // Call at a synchronisation, after the members have changed. `sub_step_s`: of the last tick.
  void renew(const WorldSnapshot& snapshot, const physics::BorderTraits& traits, double sub_step_s,
             physics::World& world) noexcept;
  // Call once a tick. Scales the velocities of outside surfaces and ghosts.
  void slow_down(const WorldLateness& late, physics::World& world) const noexcept;

  void save(ByteWriter& out) const noexcept;
  [[nodiscard]] bool restore(ByteReader& in, const physics::World& world) noexcept;
  std::size_t save_size_bound() const noexcept {
    return sizeof(std::uint32_t) + outside_velocity_.capacity() * sizeof(Vec3d);
  }

 private:
  // The impulses of a contact before the synchronisation.
  struct Former {
    BodyId member{kNoBody}, outside{kNoBody};
    std::uint32_t feature{}, parts{};
    double normal_impulse{}, tangent_impulse[2]{};
  };
  void keep_impulses(std::span<const physics::BorderContact> contacts) noexcept;
  void continue_from_former(std::uint32_t& hint, physics::BorderContact& contact) const noexcept;

  BoundedVector<Vec3d> outside_velocity_;  // m/s, world: per border contact, from the snapshot
  BoundedVector<Former> former_;           // scratch of renew
};

}  // namespace tactus::haptics
