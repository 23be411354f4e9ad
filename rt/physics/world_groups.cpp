// Inserts and removes many bodies of a world at once: whole islands.
#include "rt/physics/world.h"

namespace tactus::physics {

bool World::insert(std::span<const Body> bodies) noexcept {
  const std::uint32_t before = bodies_.size(), added = static_cast<std::uint32_t>(bodies.size());
  if (added > bodies_.capacity() - before) return refuse(kBodiesFull);
  const std::uint32_t after = before + added;
  bodies_.resize(after);
  frozen_.resize(after);
  wrenches_.resize(after);
  last_poses_.resize(after);
  moved_to_.resize(before);
  // Merges from the back, so that no element is overwritten before it is moved.
  std::uint32_t old = before, next = added;
  for (std::uint32_t slot = after; slot-- > 0;) {
    if (next == 0 || (old > 0 && bodies[next - 1].id < bodies_[old - 1].id)) {
      move_body(--old, slot);
      continue;
    }
    const Body& body = bodies[--next];
    TACTUS_CHECK(body.kind == BodyKind::kDynamic && (slot + 1 == after || body.id < bodies_[slot + 1].id), body.id,
                 slot);
    bodies_[slot] = body;
    frozen_[slot] = 0;
    wrenches_[slot] = {};
    last_poses_[slot] = unknown_pose();
  }
  follow_moves();
  return true;
}

void World::remove(std::span<const std::uint8_t> leaving) noexcept {
  TACTUS_CHECK(leaving.size() == bodies_.size(), leaving.size(), bodies_.size());
  moved_to_.resize(bodies_.size());
  std::uint32_t kept = 0;
  for (std::uint32_t slot = 0; slot < bodies_.size(); ++slot) {
    if (leaving[slot] != 0)
      moved_to_[slot] = kNoSlot;
    else
      move_body(slot, kept++);
  }
  bodies_.resize(kept);
  frozen_.resize(kept);
  wrenches_.resize(kept);
  last_poses_.resize(kept);
  follow_moves();
}

void World::move_body(std::uint32_t from, std::uint32_t to) noexcept {
  moved_to_[from] = to;
  if (from == to) return;
  bodies_[to] = bodies_[from];
  frozen_[to] = frozen_[from];
  wrenches_[to] = wrenches_[from];
  last_poses_[to] = last_poses_[from];
}

// Updates everything that refers to bodies by slot.
void World::follow_moves() noexcept {
  contacts_.slots_moved(moved_to_.span());
  for (auto& spring : springs_) {
    if (!spring.enabled) continue;
    const std::uint32_t to = moved_to_[number_of(spring.slot)];
    if (to == kNoSlot)
      spring.enabled = false;
    else
      spring.slot = SlotIndex{to};
  }
}

}  // namespace tactus::physics
