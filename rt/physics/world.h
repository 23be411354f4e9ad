// A world of rigid bodies in fixed arrays: the engine of the haptic sub-world and of the global world.
//
// One step: bounds -> (the caller finds pairs) -> narrow phase -> soft-step solver: per sub-step warm start, biased
// sweep, integrate, relax sweep; and the stages of the scene's effects (effects/stage.h). The order is fixed: bodies by
// id, contacts by pair key; the same input gives the same bits.
// Thread: construction is [setup]; everything else [rt], by the one owner. No call allocates, throws or logs.
// Frame: world. Units: SI. Bound: work is linear in pairs and points; capacities as given, overflow by capacity.h.
// Source: soft-step solver (Catto, Solver2D); implicit-midpoint gyroscopic term.
#pragma once

#include <array>
#include <limits>
#include <optional>

#include "rt/base/bounded_vector.h"
#include "rt/base/bytes.h"
#include "rt/physics/body.h"
#include "rt/physics/border/border_contact.h"
#include "rt/physics/capacity.h"
#include "rt/physics/collision/fixed_tree.h"
#include "rt/physics/collision/near_triangles.h"
#include "rt/physics/collision/pair_finder.h"
#include "rt/physics/collision/pair_order.h"
#include "rt/physics/contact/contact.h"
#include "rt/physics/contact/contact_table.h"
#include "rt/physics/contact/warm_start.h"
#include "rt/physics/effects/effects.h"
#include "rt/physics/pose_spring.h"
#include "rt/physics/slot_index.h"
#include "rt/physics/solver.h"
#include "rt/physics/step.h"
#include "rt/physics/sweep_precision.h"

namespace tactus::physics {

class World {
 public:
  // [setup] Allocates and touches all memory. `shapes`: the lists to which the bodies' shapes refer; they and the spans
  // in `effects` must outlive the world and stay unchanged. `precision`: raised to kFull if an effect other than
  // gravity has stages.
  explicit World(const Capacities& capacities, const ShapeLists& shapes = {}, const EffectSetups& effects = {},
                 SweepPrecision precision = SweepPrecision::kFull);
  SweepPrecision precision() const noexcept { return solver_ ? SweepPrecision::kFull : SweepPrecision::kSingle; }

  // [setup] Shares the work of each step with the executor where that saves time; the results are bit-identical.
  void share_work(const Executor& executor) noexcept { executor_ = executor; }

  // --- membership. Slots are in the order of body ids; inserting or removing a body moves the slots above it.
  // Returns false (and sets kBodiesFull or kFixedBodiesFull in the next report) if the world is full or has the id
  // already.
  bool insert(const Body& body) noexcept;
  // Removes the body and its contacts. False if the id is unknown.
  bool remove(BodyId id) noexcept;
  // Inserts many dynamic bodies in one pass over the world: sorted by id, none of them in the world yet. Their bounds
  // and pairs are computed by the next begin_step. If not all fit, inserts none and returns false (and kBodiesFull).
  bool insert(std::span<const Body> bodies) noexcept;
  // Removes all dynamic bodies whose flag (by slot) is set, and their contacts.
  void remove(std::span<const std::uint8_t> leaving) noexcept;
  // The slot of a dynamic body; empty if the world does not have it.
  std::optional<SlotIndex> slot_of(BodyId id) const noexcept;
  // A dynamic body by id; null if the world does not have it.
  Body* find(BodyId id) noexcept;
  const Body* find(BodyId id) const noexcept;

  std::span<Body> bodies() noexcept { return bodies_.span(); }  // dynamic, by id
  std::span<const Body> bodies() const noexcept { return bodies_.span(); }
  Body& body(SlotIndex slot) noexcept { return bodies_[number_of(slot)]; }
  const Body& body(SlotIndex slot) const noexcept { return bodies_[number_of(slot)]; }
  std::span<const Body> fixed_bodies() const noexcept { return fixed_bodies_.span(); }  // by id
  const ShapeLists& shapes() const noexcept { return shapes_; }  // to which the bodies' shapes refer
  // Poses at the start of the last step, by slot; unknown_pose() for bodies inserted since.
  std::span<const Posed> last_poses() const noexcept { return last_poses_.span(); }

  // [setup] Call after the last fixed body; otherwise the next step does it.
  void index_fixed_bodies() noexcept;

  // --- one step, in three calls: begin_step, the caller's pair finder, finish_step. `settings` must be the same in
  // both, and no body may be moved in between. With a coarse region, pass begin_step the smaller number of sub-steps:
  // the bounds must cover the longer fall (motion_bound.h).
  // Computes the bounds of all bodies: the bounds of two bodies that may touch overlap.
  void begin_step(const StepSettings& settings) noexcept;
  std::span<const Aabb> bounds() const noexcept { return bounds_.span(); }              // by slot, dynamic bodies
  std::span<const Aabb> fixed_bounds() const noexcept { return fixed_bounds_.span(); }  // by fixed slot
  // Filled by the pair finder, cleared by begin_step. After the step: all pairs whose bounds overlapped, by key.
  BoundedVector<SlotPair>& dynamic_pairs() noexcept { return dynamic_pairs_; }
  // `coarse`: not in a world with border contacts; a body on a spring is never coarse.
  StepReport finish_step(const StepSettings& settings, const CutPredicate& cut = {},
                         const CoarseRegion& coarse = {}) noexcept;

  // Optional: triangles known to be near the bodies, valid until set again; they only save work.
  NearTriangles near_triangles;

  // --- contacts of the last step, by pair key
  std::span<const Contact> contacts() const noexcept { return contacts_.contacts(); }
  // Impulses for the next step, by pair and feature; those of unknown pairs are kept until the next step finds the
  // pair.
  bool add_warm_start(const WarmStart& warm_start) noexcept { return contacts_.add_warm_start(warm_start); }
  // Continues a contact of another world: the axis along which the pair touches and its impulses, in sub-steps of
  // `sub_step_s`, replace what the next step would start from. False if the list is full.
  bool continue_contact(const WarmStart& given, double sub_step_s) noexcept {
    return contacts_.continue_contact(given, sub_step_s);
  }
  // The contact's impulses, in the form in which another world takes them.
  static WarmStart warm_start_of(const Contact& contact, double sub_step_s) noexcept;

  // --- constraints from outside the world
  PoseSpring& device_spring(std::uint32_t device = 0) noexcept { return springs_[device]; }
  const PoseSpring& device_spring(std::uint32_t device = 0) const noexcept { return springs_[device]; }
  // Returns false (and sets kBorderContactsFull in the next report) if the list is full.
  bool add_border_contact(const BorderContact& contact) noexcept;
  BoundedVector<BorderContact>& border_contacts() noexcept { return border_contacts_; }
  const BoundedVector<BorderContact>& border_contacts() const noexcept { return border_contacts_; }
  // At most as many as border contacts, which refer to them by index.
  BoundedVector<BorderGhost>& border_ghosts() noexcept { return border_ghosts_; }
  const BoundedVector<BorderGhost>& border_ghosts() const noexcept { return border_ghosts_; }
  BorderRule border_rule;

  // Applies a wrench to a dynamic body over the next step, then clears it. N, N m about its centre, world.
  void apply_wrench(SlotIndex slot, const Wrenchd& wrench) noexcept;
  // Changes the velocity at once. N s, N m s about its centre, world.
  void apply_impulse(SlotIndex slot, const Wrenchd& impulse) noexcept;

  // Freezes a body: while set it neither moves nor takes impulses, and it keeps its pose and the velocity with which it
  // continues afterwards (the static coupling). To other bodies it is at rest and infinitely heavy.
  void set_frozen(SlotIndex slot, bool frozen) noexcept;

  // The effects: their state, and its transfer to and from another world.
  Effects& effects() noexcept { return effects_; }
  const Effects& effects() const noexcept { return effects_; }

  // --- diagnostics
  double kinetic_energy() const noexcept;                        // J, dynamic bodies
  double potential_energy(const Vec3d& gravity) const noexcept;  // J, -sum m g.x
  double joint_springs_J(double contact_hertz) const noexcept;   // Joints::springs_J; 0 without joints
  Wrenchd momentum() const noexcept;                             // N s; N m s about the world origin
  std::uint64_t state_hash() const noexcept;                     // poses, velocities and ids, in slot order

  // --- the complete state on which the next step depends (bodies, contacts, warm starts, spring, border contacts,
  // flags), for keyframes and replay. Restore needs a world of the same capacities.
  void save(ByteWriter& out) const noexcept;
  std::size_t save_size_bound() const noexcept;  // bytes that `save` never exceeds
  // Returns false, and leaves the world empty, if the bytes are too short, exceed the capacities or are inconsistent.
  [[nodiscard]] bool restore(ByteReader& in) noexcept;

 private:
  void clear() noexcept;
  bool is_consistent() const noexcept;
  bool refuse(CapacityBit bit) noexcept;
  void add_pairs(StageContext& context) noexcept;
  void add_fixed_pair(const SlotPair& pair, const StepSettings& settings, StepReport& report) noexcept;
  void find_fixed_pairs(const StepSettings& settings, StepReport& report) noexcept;
  void sort_fixed_pairs() noexcept;
  void add_fixed_pairs(StageContext& context) noexcept;
  void add_part_pairs(const SlotPair& pair, bool fixed, const StepSettings& settings) noexcept;
  void add_mesh_pairs(std::uint32_t slot, std::uint32_t fixed_slot, const StepSettings& settings,
                      StepReport& report) noexcept;
  std::uint32_t add_patch_pairs(const PosedPart& part, BodyPart of, std::uint32_t slot, std::uint32_t fixed_slot,
                                const StepSettings& settings) noexcept;
  void solve(std::span<const std::uint8_t> frozen, std::span<PoseSpring> springs, const StepSettings& settings,
             double impulse_scale, const CutPredicate& cut, StepReport& report) noexcept;
  void solve_coarse(const CoarseRegion& coarse, const StepSettings& settings, const CutPredicate& cut,
                    StepReport& report) noexcept;
  void move_body(std::uint32_t from, std::uint32_t to) noexcept;
  void follow_moves() noexcept;

  Capacities capacities_;
  ShapeLists shapes_;
  Executor executor_;
  BoundedVector<Body> bodies_, fixed_bodies_;  // by id
  BoundedVector<std::uint8_t> frozen_;         // by slot
  mutable BoundedVector<std::uint8_t>
      frozen_in_solve_;              // by slot; scratch of a step with a coarse region, and of joint_springs_J
  BoundedVector<Wrenchd> wrenches_;  // by slot: for the next step
  bool wrench_applied_{false};
  BoundedVector<Aabb> bounds_, fixed_bounds_;
  BoundedVector<BodyFrame> frames_, fixed_frames_;
  BoundedVector<MotionBound> motion_bounds_;  // by slot
  double fall_{};                             // m: fall_in_step of this step
  double growth_to_fixed_{};                  // m: additional growth of bounds against fixed bodies, in this step
  BoundedVector<Posed> last_poses_;           // by slot: at the start of the last step; unknown_pose() for new bodies
  BoundedVector<std::uint32_t> moved_to_;     // scratch of insert and remove
  FixedTree fixed_tree_;
  bool fixed_is_indexed_{false};
  BoundedVector<SlotPair> fixed_pairs_;          // (fixed slot, slot): bounds that overlap
  BoundedVector<std::uint32_t> mesh_triangles_;  // of this step, pair by pair
  PairOrder pair_order_;
  BoundedVector<SlotPair> dynamic_pairs_;  // holds one more than the capacity, to detect overflow
  ContactTable contacts_;
  Effects effects_;
  std::optional<Solver<double>> solver_;  // one of the two, by the precision
  std::optional<Solver<float>> single_solver_;
  std::array<PoseSpring, kMaxSprings> springs_;
  BoundedVector<BorderContact> border_contacts_;
  BoundedVector<BorderGhost> border_ghosts_;
  double last_sub_step_{};                      // s: the sub-step of the stored impulses; 0 before the first step
  std::uint32_t refused_bits_{0}, refused_{0};  // by insert and add, for the next report
};

}  // namespace tactus::physics
