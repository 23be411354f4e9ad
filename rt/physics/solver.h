// One step of the soft-step solver: sub-steps of forces, warm start, biased sweep, integration, relax sweeps.
//
// A device's spring is part of its body (pose_spring.h). Order in every sweep: the stages of effects, the border
// contacts, the contacts by colours.
// Cut: the predicate is asked before each sweep. Once it asks to stop, only one more relax sweep runs, at the very end.
// The remaining sub-steps still integrate; their warm start is scaled down where it would raise the kinetic energy (an
// impulse that once stopped an impact must not be applied again). The last relax sweep then corrects n sub-steps at
// once, and the next warm start gets 1/n of its correction, because it is applied n times; with the whole correction,
// repeatedly cut steps would make stacks fall apart.
// Frame: world. Units: SI. Thread: construction [setup], the rest [rt]. Bound: sub-steps x sweeps x points.
//
// S, the number type of the sweeps, is double or narrower (SweepPrecision). Within a step, motion and contacts are
// relative to the bodies' poses at its start, so positions far from the world's origin lose no precision. Only what a
// step adds to poses and velocities has the precision of S. With S narrower than double the solver takes no border
// contacts, and only the effects that Effects::suit_single_precision names: gravity is applied in S, a stage of
// scripted motion gets a copy of the motion in double.
#pragma once

#include <array>
#include <type_traits>

#include "rt/physics/border/border_solver.h"
#include "rt/physics/capacity.h"
#include "rt/physics/contact/contact_solver.h"
#include "rt/physics/effects/stage.h"
#include "rt/physics/spring_solver.h"
#include "rt/physics/step.h"

namespace tactus::physics {

// Input of a step; everything by slot.
struct SolverInput {
  std::span<Body> bodies;
  std::span<const std::uint8_t> frozen;
  std::span<const Wrenchd> wrenches;  // N, N m; empty where no body has one
  std::span<Contact> contacts;        // by key
  std::span<PoseSpring> springs;      // kMaxSprings at most
  std::span<BorderContact> border;
  std::span<BorderGhost> ghosts;
  BorderRule border_rule;
  double impulse_scale;      // this sub-step / the sub-step of the stored border impulses
  const StageTable& stages;  // of effects
  std::span<const Body> fixed_bodies{};
  Executor executor{};
};

// Takes the place of the border solver where S is narrower than double.
template <class S>
struct NoBorder {
  explicit NoBorder(const Capacities&) noexcept {}
  void begin_sub_step(std::uint32_t, SolverBodies<S>) noexcept {}
  void count_joints(double) noexcept {}
  bool may_supply() const noexcept { return false; }
  double left_J() const noexcept { return 0.0; }
  void apply_replay(SolverBodies<S>) noexcept {}
  void warm_start(SolverBodies<S>) noexcept {}
  void solve_biased(SolverBodies<S>, const SweepRule<S>&) noexcept {}
  void relax(SolverBodies<S>, const SweepRule<S>&, bool) noexcept {}
  void move_ghosts() noexcept {}
  void find_offsets(SolverBodies<S>) noexcept {}
  void end_sub_step(SolverBodies<S>) noexcept {}
  void scale_impulses(S) noexcept {}
};

template <class S>
class Solver {
 public:
  // [setup] `scripted`: the world has bodies with a script; only then are there copies for stages.
  Solver(const Capacities& capacities, bool scripted);

  void step(const SolverInput& input, const StepSettings& settings, const CutPredicate& cut,
            StepReport& report) noexcept;

 private:
  static constexpr bool kIsWhole = std::is_same_v<S, double>;  // with border contacts and the stages of effects

  void prepare(const SolverInput& input, StageContext& context) noexcept;
  void run_stages(const SolverInput& input, Phase phase, StageContext& context) noexcept;
  void run_stages_in_double(const SolverInput& input, Phase phase, StageContext& context) noexcept;
  void apply_gravity(const SolverInput& input, const StageContext& context) noexcept;
  void apply_wrenches(const SolverInput& input, double h) noexcept;
  void warm_start_without_gain(const SolverInput& input, StageContext& context) noexcept;
  void sweep_relax(const SolverInput& input, const SweepRule<S>& rule, StageContext& context, bool last) noexcept;
  void store(const SolverInput& input, StageContext& context, std::uint32_t uncorrected) noexcept;
  SolverBodies<S> state() noexcept { return {motion_.span(), inverse_inertia_.span()}; }

  BoundedVector<SolverBody<S>> motion_;
  BoundedVector<SymMat3<S>> inverse_inertia_;
  // Copies for the stages of scripted motion, if S is narrower than double.
  BoundedVector<SolverBody<double>> motion_in_double_;
  BoundedVector<SymMat3d> inverse_inertia_in_double_;
  BoundedVector<Twist<S>> before_;       // velocities before a warm start that may be scaled down
  BoundedVector<std::uint32_t> pushed_;  // slots of the bodies with a wrench
  ContactSolver<S> contacts_;
  std::conditional_t<kIsWhole, BorderSolver, NoBorder<S>> border_;
  std::array<SpringSolver<S>, kMaxSprings> springs_;
};

}  // namespace tactus::physics
