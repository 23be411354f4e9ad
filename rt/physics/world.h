// A world of rigid bodies in fixed arrays: the engine of the haptic sub-world and of the global world alike.
//
// One step: bounds -> (the caller finds pairs) -> narrow phase -> soft-step solver: per sub-step warm start, biased
// sweep, integrate, relax sweep; and the stages of the effects that it was made with (effects/stage.h). Order is fixed:
// bodies by id, contacts by pair key; same input, same bits.
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
#include "rt/physics/solver.h"
#include "rt/physics/step.h"
#include "rt/physics/sweep_precision.h"

namespace tactus::physics {

class World {
 public:
  // [setup] Allocates and touches everything. `hulls`, `meshes`: what the bodies' shapes refer to; they and what the
  // effects are told must outlive the world and stay the same. `precision`: full all the same where an effect other
  // than gravity has stages.
  explicit World(const Capacities& capacities, Hulls hulls = {}, Meshes meshes = {}, const EffectSetups& effects = {},
                 SweepPrecision precision = SweepPrecision::kFull);
  SweepPrecision precision() const noexcept { return solver_ ? SweepPrecision::kFull : SweepPrecision::kSingle; }

  // [setup] From now on the work of a step is shared where that pays; the results stay, bit by bit.
  void share_work(const Executor& executor) noexcept { executor_ = executor; }

  // --- membership. Slots are in the order of body ids; inserting or removing moves the slots above.
  // False (and kBodiesFull or kFixedBodiesFull in the next report) when there is no room or the id is there already.
  bool insert(const Body& body) noexcept;
  // Also forgets its contacts. False when it is not there.
  bool remove(BodyId id) noexcept;
  // Many dynamic bodies at once, in one pass over the world: none of them is there, and they come by id. Their bounds
  // and pairs come with the next begin_step. False (and kBodiesFull) when there is no room for all: then none.
  bool insert(std::span<const Body> bodies) noexcept;
  // All whose flag is set, by slot, and their contacts.
  void remove(std::span<const std::uint8_t> leaving) noexcept;
  // The slot of a dynamic body, or -1.
  std::int32_t slot_of(BodyId id) const noexcept;

  std::span<Body> bodies() noexcept { return bodies_.span(); }  // dynamic, by id
  std::span<const Body> bodies() const noexcept { return bodies_.span(); }
  std::span<const Body> fixed_bodies() const noexcept { return fixed_bodies_.span(); }  // by id
  // Where the bodies were when the last step began, by slot; no pose for those that came since.
  std::span<const Posed> last_poses() const noexcept { return last_poses_.span(); }

  // [setup] After the last fixed body: or else the next step does it.
  void index_fixed_bodies() noexcept;

  // --- one step, in three calls. `settings` must be the same in all three, and no body is moved between them. With a
  // far region, begin_step is told the fewer of the sub-steps: bounds grow by how far a body may fall.
  // Bounds of all bodies: those of two that may touch overlap.
  void begin_step(const StepSettings& settings) noexcept;
  std::span<const Aabb> bounds() const noexcept { return bounds_.span(); }              // by slot, dynamic bodies
  std::span<const Aabb> fixed_bounds() const noexcept { return fixed_bounds_.span(); }  // by fixed slot
  // For the pair finder; cleared by begin_step. After the step, all pairs of bounds that overlapped, by key.
  BoundedVector<SlotPair>& dynamic_pairs() noexcept { return dynamic_pairs_; }
  // `far`: not in a world with border contacts; a body on a spring is not far.
  StepReport finish_step(const StepSettings& settings, const CutPredicate& cut = {},
                         const FarRegion& far = {}) noexcept;

  // Triangles near the bodies where they are known beforehand, valid until set anew: they save work, no more.
  NearTriangles near_triangles;

  // --- contacts of the last step, by pair key
  std::span<const Contact> contacts() const noexcept { return contacts_.contacts(); }
  // For the next step: impulses by pair and feature; unknown pairs are kept until the next step finds them.
  bool add_warm_start(const WarmStart& warm_start) noexcept { return contacts_.add_warm_start(warm_start); }
  // What the contact holds, for another world.
  static WarmStart warm_start_of(const Contact& contact, double sub_step_s) noexcept;

  // --- constraints from outside the world
  PoseSpring& device_spring(std::uint32_t device = 0) noexcept { return springs_[device]; }
  // Adds one; false (and kBorderContactsFull in the next report) when there is no room.
  bool add_border_contact(const BorderContact& contact) noexcept;
  BoundedVector<BorderContact>& border_contacts() noexcept { return border_contacts_; }
  const BoundedVector<BorderContact>& border_contacts() const noexcept { return border_contacts_; }
  // As many as border contacts, at most. Border contacts name them by index.
  BoundedVector<BorderGhost>& border_ghosts() noexcept { return border_ghosts_; }
  const BoundedVector<BorderGhost>& border_ghosts() const noexcept { return border_ghosts_; }
  BorderMode border_mode{BorderMode::kCapped};
  double border_budget_J{std::numeric_limits<double>::max()};  // set before each step; see BorderSolver

  // A wrench on a dynamic body, held over the next step, then forgotten. N, N m about its centre, world.
  void apply_wrench(std::uint32_t slot, const Wrenchd& wrench) noexcept;
  // Changes the velocity at once. N s, N m s about its centre, world.
  void apply_impulse(std::uint32_t slot, const Wrenchd& impulse) noexcept;

  // A body that neither moves nor feels impulses while set, but keeps its place and the velocity that it goes on with
  // (the static coupling). To the others it is at rest and infinitely heavy.
  void set_frozen(std::uint32_t slot, bool frozen) noexcept;

  // What is called for beside contacts: their state, and handing it over to another world.
  Effects& effects() noexcept { return effects_; }
  const Effects& effects() const noexcept { return effects_; }

  // --- books
  double kinetic_energy() const noexcept;                        // J, dynamic bodies
  double potential_energy(const Vec3d& gravity) const noexcept;  // J, -sum m g.x
  Wrenchd momentum() const noexcept;                             // N s; N m s about the world origin
  std::uint64_t state_hash() const noexcept;                     // poses, velocities and ids, in slot order

  // --- everything that the next step depends on (bodies, contacts, warm starts, spring, border contacts, flags), for
  // keyframes and replay. Restore needs a world of the same capacities.
  void save(ByteWriter& out) const noexcept;
  std::size_t save_size_bound() const noexcept;  // bytes that `save` never exceeds
  // False, and the world is empty, when the bytes are short, hold more than fits or are no world.
  [[nodiscard]] bool restore(ByteReader& in) noexcept;

 private:
  void clear() noexcept;
  bool is_consistent() const noexcept;
  bool refuse(CapacityBit bit) noexcept;
  void add_pairs(StageContext& context) noexcept;
  void add_fixed_pair(const SlotPair& pair, const StepSettings& settings, StepReport& report) noexcept;
  void find_fixed_pairs(const StepSettings& settings, StepReport& report) noexcept;
  void add_fixed_pairs(StageContext& context) noexcept;
  void add_mesh_pairs(std::uint32_t slot, std::uint32_t fixed_slot, double margin, StepReport& report) noexcept;
  void solve(std::span<const std::uint8_t> held, std::span<PoseSpring> springs, const StepSettings& settings,
             double impulse_scale, const CutPredicate& cut, StepReport& report) noexcept;
  void solve_far(const FarRegion& far, const StepSettings& settings, const CutPredicate& cut,
                 StepReport& report) noexcept;
  void move_body(std::uint32_t from, std::uint32_t to) noexcept;
  void follow_moves() noexcept;

  Capacities capacities_;
  Hulls hulls_;
  Meshes meshes_;
  Executor executor_;
  BoundedVector<Body> bodies_, fixed_bodies_;  // by id
  BoundedVector<std::uint8_t> frozen_, held_;  // by slot; held_: scratch of a step by regions
  BoundedVector<Wrenchd> wrenches_;            // by slot: of the next step
  bool wrench_applied_{false};
  BoundedVector<Aabb> bounds_, fixed_bounds_;
  BoundedVector<BodyFrame> frames_, fixed_frames_;
  BoundedVector<MotionBound> motion_bounds_;  // by slot
  double growth_to_fixed_{};                  // m, of bounds beside a fixed body, in this step
  BoundedVector<Posed> last_poses_;           // by slot: at the start of the last step; unknown_pose() of newcomers
  BoundedVector<std::uint32_t> moved_to_;     // scratch of insert and remove
  FixedTree fixed_tree_;
  bool fixed_is_indexed_{false};
  BoundedVector<SlotPair> fixed_pairs_;          // fixed slot, slot: boxes that overlap
  BoundedVector<std::uint32_t> mesh_triangles_;  // of this step, pair by pair
  PairOrder pair_order_;
  BoundedVector<SlotPair> dynamic_pairs_;  // room for one more than the capacity, so that overflow shows
  ContactTable contacts_;
  Effects effects_;
  std::optional<Solver<double>> solver_;  // one of the two
  std::optional<Solver<float>> single_solver_;
  std::array<PoseSpring, kMaxSprings> springs_;
  BoundedVector<BorderContact> border_contacts_;
  BoundedVector<BorderGhost> border_ghosts_;
  double last_sub_step_{};                      // s, of the stored impulses; 0 before the first step
  std::uint32_t refused_bits_{0}, refused_{0};  // of insert and add, for the next report
};

}  // namespace tactus::physics
