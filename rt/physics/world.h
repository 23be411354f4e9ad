// A world of rigid bodies in fixed arrays: the engine of the haptic sub-world and of the global world alike.
//
// One step: bounds -> (the caller finds pairs) -> narrow phase -> soft-step solver: per sub-step warm start, biased
// sweep, integrate, relax sweep. Order is fixed: bodies by id, contacts by pair key; same input, same bits.
// Thread: construction is [setup]; everything else [rt], by the one owner. No call allocates, throws or logs.
// Frame: world. Units: SI. Bound: work is linear in pairs and points; capacities as given, overflow by capacity.h.
// Source: soft-step solver (Catto, Solver2D); implicit-midpoint gyroscopic term.
#pragma once

#include "rt/base/bounded_vector.h"
#include "rt/base/bytes.h"
#include "rt/physics/body.h"
#include "rt/physics/border_contact.h"
#include "rt/physics/capacity.h"
#include "rt/physics/contact.h"
#include "rt/physics/pose_spring.h"
#include "rt/physics/step.h"

namespace tactus::physics {

// Two slots whose bounds overlap. Filled by a pair finder, in any order; the world sorts.
struct SlotPair {
  std::uint32_t a{0}, b{0};
};

// Impulses of a contact that another world knew, so that a body that moves between worlds keeps its warm start.
// In newtons (impulse / sub-step): the two worlds' sub-steps differ.
template <class T>
struct WarmStart {
  PairKey key;
  AxisCache axis_cache;
  std::uint32_t count{0};
  std::array<std::uint32_t, kMaxManifoldPoints> features{};
  std::array<T, kMaxManifoldPoints> normal_force{};       // N
  std::array<Vec3<T>, kMaxManifoldPoints> friction_force{};  // N, on B, world
};

template <class T>
class World {
 public:
  explicit World(const Capacities& capacities);  // [setup] allocates and touches everything

  // --- membership. Slots are in the order of body ids; inserting or removing moves the slots above.
  // False (and kBodiesFull or kFixedBodiesFull in the next report) when there is no room or the id is there already.
  bool insert(const Body<T>& body) noexcept;
  // Also forgets its contacts. False when it is not there.
  bool remove(BodyId id) noexcept;
  // The slot of a dynamic body, or -1.
  std::int32_t slot_of(BodyId id) const noexcept;

  std::span<Body<T>> bodies() noexcept;  // dynamic, by id
  std::span<const Body<T>> bodies() const noexcept;
  std::span<const Body<T>> fixed_bodies() const noexcept;  // by id

  // --- one step, in three calls. `settings` must be the same in all three.
  void begin_step(const StepSettings<T>& settings) noexcept;     // bounds of all bodies, grown by what they move in dt
  std::span<const Aabb<T>> bounds() const noexcept;              // by slot, dynamic bodies
  std::span<const Aabb<T>> fixed_bounds() const noexcept;        // by fixed slot
  BoundedVector<SlotPair>& dynamic_pairs() noexcept;             // for the pair finder; cleared by begin_step
  StepReport<T> finish_step(const StepSettings<T>& settings, const CutPredicate& cut = {}) noexcept;

  // --- contacts of the last step, by pair key
  std::span<const Contact<T>> contacts() const noexcept;
  // For the next step: impulses by pair and feature; unknown pairs are kept until the next step finds them.
  bool add_warm_start(const WarmStart<T>& warm_start) noexcept;
  // What the contact holds, for another world.
  static WarmStart<T> warm_start_of(const Contact<T>& contact, T sub_step_s) noexcept;

  // --- constraints from outside the world
  PoseSpring<T>& device_spring() noexcept;
  BoundedVector<BorderContact<T>>& border_contacts() noexcept;
  const BoundedVector<BorderContact<T>>& border_contacts() const noexcept;
  BorderMode border_mode{BorderMode::kCapped};

  // A wrench on a dynamic body, held over the next step, then forgotten. N, N m about its centre, world.
  void apply_wrench(std::uint32_t slot, const Wrench<T>& wrench) noexcept;
  // Changes the velocity at once. N s, N m s about its centre, world.
  void apply_impulse(std::uint32_t slot, const Wrench<T>& impulse) noexcept;

  // A body that neither moves nor feels impulses while set, but keeps its place (the static coupling).
  void set_frozen(std::uint32_t slot, bool frozen) noexcept;

  // --- books
  T kinetic_energy() const noexcept;                         // J, dynamic bodies
  T potential_energy(const Vec3<T>& gravity) const noexcept;  // J, -sum m g.x
  Wrench<T> momentum() const noexcept;                       // N s; N m s about the world origin
  std::uint64_t state_hash() const noexcept;                 // poses, velocities and ids, in slot order

  // --- everything that the next step depends on (bodies, contacts, warm starts, spring, border contacts, flags), for
  // keyframes and replay. Restore needs a world of the same capacities.
  void save(ByteWriter& out) const noexcept;
  [[nodiscard]] bool restore(ByteReader& in) noexcept;
  std::size_t save_size_bound() const noexcept;

 private:
};

// All pairs of dynamic bodies whose bounds overlap, by brute force: O(n^2), fixed order, no structure. [rt]
template <class T>
bool find_pairs_brute_force(std::span<const Aabb<T>> bounds, BoundedVector<SlotPair>& pairs) noexcept;

}  // namespace tactus::physics
