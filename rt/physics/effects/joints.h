// Effect joints: the joints of the scene; active are those whose bodies are in this world.
//
// Rows are soft-step rows as those of contacts, with the same frequency and damping: soft in the biased sweep, at
// velocity level in the relax sweep. The three force rows are one 3 x 3 system in the joint's axes, the three torque
// rows another; a free direction has no mass. Limits are unilateral rows as those of a contact; a motor is a row of
// bounded effort. Axes, lever arms and masses are those at the start of the sub-step. Order in a sweep: joint after
// joint by B's id; within a joint the axis, then torques, then forces.
// A joint with a body of another world acts on that body's ghost, which responds by its admittance (border_ghost.h).
// Without a ghost it acts on an anchor, which moves with the body's last known velocity.
// Against a ghost the stiffness is that of a joint of the two bodies alone, independent of what moves with the outside
// body, as for a border contact (ghost_row.h). With A = J W J^T of body and ghost and A' that of the two bodies,
// the biased sweep solves (A + A' / a2) dp = -(u + rate error + A' / a2 p), a2 of softness.h. With A in place of A', a
// ghost of large apparent inertia makes the joint up to twice as stiff as in the global world: a hanging body is lifted
// by half of its sag in each cycle and returned at each synchronisation (tests/border/hanging.toml: 2.7 um of 6), and a
// load held by friction slips.
// Source: Catto, soft constraints; block rows as in Box2D.
// Frame: world. Units: SI. Thread: construction [setup]; the rest [rt], the owner of the World. Bound: linear in the
// joints of the bodies in this world, x log bodies.
#pragma once

#include <algorithm>

#include "rt/physics/body_frame.h"
#include "rt/physics/border/work_limit.h"
#include "rt/physics/effects/joint.h"
#include "rt/physics/effects/stage.h"

namespace tactus::physics {

class Joints {
 public:
  struct Setup {
    std::span<const Joint> joints{};  // must outlive the world
    bool used() const noexcept { return !joints.empty(); }
  };
  Joints(const Setup& setup, const Capacities& capacities);
  void register_stages(StageTable& table) noexcept;

  std::span<const Joint> joints() const noexcept { return joints_; }
  std::span<const JointState> states() const noexcept { return states_.span(); }  // by joint
  // Starts from these efforts, by joint, as if they were those of the last sub-step.
  void start_from(std::span<const JointState> states) noexcept {
    for (std::size_t k = 0; k < std::min<std::size_t>(states.size(), states_.size()); ++k)
      states_[static_cast<std::uint32_t>(k)].effort = states[k].effort;
  }
  // Calls `f(slot_a, slot_b, joint)` for joints between two of these bodies, in the order of B.
  template <class F>
  void for_each_link(std::span<const Body> bodies, F&& f) const noexcept {
    for (std::uint32_t slot = 0; slot < bodies.size(); ++slot)
      for (const std::uint32_t k : joints_of(bodies[slot].id)) {
        if (states_[k].broken != 0 || joints_[k].b != bodies[slot].id) continue;
        if (const std::uint32_t a = slot_of(bodies, joints_[k].a); a != kNoSlot) f(a, slot, k);
      }
  }

  // Energy of the springs that hold the joints together at the bodies' poses [J]: sum of e . M e w^2 / 2 over locked
  // axes and passed limits, w = 2 pi contact_hertz, e: the error, M: the effective mass. Of joints between two of these
  // bodies, or one of them and a fixed body or the world. `frozen`, by slot: 1: of infinite mass.
  double springs_J(std::span<const Body> bodies, std::span<const Body> fixed_bodies,
                   std::span<const std::uint8_t> frozen, double contact_hertz) const noexcept;

  void reset() noexcept;
  void save(ByteWriter& out) const noexcept;
  bool restore(ByteReader& in) noexcept;
  std::size_t save_size_bound() const noexcept;
  void export_state(ByteWriter& out, std::span<const Body> bodies, std::span<const std::uint8_t> inside) const noexcept;
  bool import_state(ByteReader& in, std::span<const Body> bodies, bool known_too) noexcept;

 private:
  static constexpr std::uint32_t kOutside = kNoSlot;

  // The motion and mass properties of a body of another world, to which a joint is connected.
  struct Anchor {
    std::uint32_t joint{0};
    BodyMotion motion;
    double inverse_mass{};  // 1/kg
    Vec3d inverse_inertia;  // 1/(kg m^2), body frame; both of that body alone, without what moves with it
  };
  struct Row {
    std::uint32_t joint{0}, slot_a{kOutside}, slot_b{kOutside};
    Vec3d arm_a, arm_b, apart;   // m: from the centres to the frames, from A's frame to B's; at the start of the step
    Quatd frame_a, frame_b;      // world_from_joint, at the start of the step
    SolverBody<double> outside;  // stands for the side that has no slot
    BodyMotion outside_motion;   // at the start of the step
    bool anchored{false};        // the side without slot is a body of another world
    std::uint32_t ghost{kNoGhost};  // the ghost of that body
    // In the present sub-step:
    Axes axes;
    Vec3d r_a, r_b, axis;  // m; axis: unit, that of the coordinate
    Vec3d linear_error, angular_error;
    double coordinate{};
    SymMat3d linear_mass, angular_mass;
    double axis_mass{};
    // Against a ghost, in the biased sweep: (A + A' / a2)^-1 and A' / a2, for forces, torques and the coordinate; and
    // the inverse mass and inertia of the ghost's body alone (0: infinite mass).
    double own_inverse_mass{};
    SymMat3d own_inverse_inertia;  // world
    SymMat3d linear_soft_mass, linear_give, angular_soft_mass, angular_give;
    double axis_soft_mass{}, axis_give{};
    JointEffort now, kept;        // N s, N m s
    Vec3d sum_force, sum_torque;  // N s, N m s, on B, world, over the step
    Twistd start_velocity;        // of the frame on the side with a slot
  };
  struct Side {
    SolverBody<double>& body;
    const SymMat3d& inverse_inertia;
    GhostState* ghost{nullptr};  // if set, `body` is a copy of this ghost's motion
  };

  static bool is_sound(const Anchor& anchor) noexcept;
  static std::uint32_t slot_of(std::span<const Body> bodies, BodyId id) noexcept;
  std::span<const std::uint32_t> joints_of(BodyId id) const noexcept;
  const Anchor* anchor_of(std::uint32_t joint) const noexcept;
  BodyId outside_of(std::uint32_t joint, std::span<const Body> bodies) const noexcept;
  Side side(StageContext& c, Row& row, std::uint32_t slot) noexcept;
  // Calls `f(joint, slot_a, slot_b)` for each joint that holds one of the bodies, once: at its body B, or at A if B is
  // in another world.
  template <class F>
  void for_each_active(std::span<const Body> bodies, std::span<const Body> fixed_bodies, F&& f) const noexcept;
  Row row_of(std::uint32_t joint, std::uint32_t slot_a, std::uint32_t slot_b, std::span<const Body> bodies,
             std::span<const Body> fixed_bodies) const noexcept;
  void measure(Row& row, const SolverBody<double>& a, const SolverBody<double>& b) const noexcept;
  void fill_masses(Row& row, const Side& a, const Side& b) const noexcept;
  void fill_give(Row& row, const Side& a, const Side& b, const Softness<double>& softness) const noexcept;
  void take_own_mass(Row& row, const StageContext& c) const noexcept;
  void add_row(StageContext& c, std::uint32_t joint, std::uint32_t slot_a, std::uint32_t slot_b) noexcept;

  void find_active(StageContext& c) noexcept;
  void separate(StageContext& c) noexcept;
  void separate_fixed(StageContext& c) noexcept;
  void prepare(StageContext& c) noexcept;
  void begin_sub_step(StageContext& c) noexcept;
  void warm_start(StageContext& c) noexcept;
  template <bool kBias>
  void solve(StageContext& c) noexcept;
  template <bool kBias>
  void solve_axis(const StageContext& c, Row& row, const Side& a, const Side& b) noexcept;
  void follow(StageContext& c) noexcept;  // updates the coordinates after the bodies have moved
  void scale(StageContext& c) noexcept;
  void keep(StageContext& c) noexcept;
  void keep_within_tank(StageContext& c) noexcept;  // limits the energy that joints to outside bodies supply
  void finish(StageContext& c) noexcept;
  void apply(const Row& row, const Side& a, const Side& b, const JointEffort& effort) const noexcept;
  static void push(const Side& side, const Vec3d& r, const Vec3d& p, const Vec3d& m) noexcept;
  static double answer(const Side& side, const Vec3d& r, const Vec3d& p, const Vec3d& q) noexcept;
  Twistd frame_velocity(const StageContext& c, const Row& row) const noexcept;
  Wrenchd impulse_on_b(const Row& row) const noexcept;  // N s, N m s, at B's frame, world
  double work_on_member(const StageContext& c, const Row& row) const noexcept;
  void take_back_work(StageContext& c, Row& row, double allowed_J) noexcept;
  Works find_works(const StageContext& c) const noexcept;  // of the rows with a body of another world
  void add_to_sums(StageContext& c, Row& row) const noexcept;

  std::span<const Joint> joints_;
  BoundedVector<JointState> states_;                   // by joint
  BoundedVector<std::uint32_t> first_of_, joints_of_;  // by body id: its first entry in joints_of_
  BoundedVector<Anchor> anchors_;                      // by joint
  BoundedVector<Row> rows_;
  BoundedVector<SlotPair> apart_, apart_fixed_;  // pairs whose joint excludes collision, sorted as the pairs
};

}  // namespace tactus::physics
