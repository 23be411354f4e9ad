// The stage table: the functions of effects that a step calls, by phase.
//
// A stage is a member function of an effect object. The table is filled once, from the effects that a scene uses; a
// phase is a loop over its stages, so an unused effect costs nothing: no branch, no call, no memory. The order within a
// phase is that of the list of effects. A stage is called once for all bodies and contacts, not once per contact.
// Thread: filling [setup]; running [rt], by the owner of the World. Frame: world. Units: SI. Bound: kMaxStages per
// phase.
#pragma once

#include <array>

#include "rt/base/bytes.h"
#include "rt/physics/border/border_ghost.h"
#include "rt/physics/capacity.h"
#include "rt/physics/collision/pair_finder.h"
#include "rt/physics/contact/contact.h"
#include "rt/physics/contact/contact_row.h"
#include "rt/physics/executor.h"
#include "rt/physics/solver_body.h"
#include "rt/physics/step.h"

namespace tactus::physics {

enum class Phase : std::uint32_t {
  kPairs = 0,         // once a step: pairs of moving bodies are complete, sorted by key; a stage may remove some
  kFixedPairs = 1,    // same for the pairs (fixed slot, slot)
  kPrepare = 2,       // the solver has its bodies, but not yet its rows
  kBeginSubStep = 3,  // velocities and poses as the last sub-step left them
  kForces = 4,        // changes velocities by what acts over h
  kWarmStart = 5,     // applies the impulses of the last sub-step again; also if no sweep follows (a cut)
  kBiased = 6,        // before the contacts' biased sweep
  kMoved = 7,         // the bodies have been moved by h
  kRelax = 8,         // before the contacts' relax sweep; called once per relax sweep
  kScale = 9,         // after a warm start without following sweeps: multiply its impulses by `factor`
  kKeep = 10,         // before the one relax sweep that corrects several sub-steps: save the impulses
  kEndSubStep = 11,   // after all sweeps; velocities may still be changed
  kFinish = 12,       // contacts have the step's impulses; velocities may still be changed. Impulses for the next step:
                      // those of kKeep plus `factor` of their change since; 1: the present ones
};
inline constexpr std::uint32_t kPhases = 13;
inline constexpr std::uint32_t kMaxStages = 16;

// Input of a stage; everything by slot except contacts and fixed bodies.
struct StageContext {
  std::span<Body> bodies;  // poses and velocities at the start of the step, until the solver stores the results
  std::span<const Body> fixed_bodies;
  std::span<const std::uint8_t> frozen;  // 1: neither moves nor takes impulses in this solve
  std::span<Contact> contacts;
  const StepSettings& settings;
  StepReport& report;
  Executor executor{};
  BoundedVector<SlotPair>* pairs{nullptr};  // kPairs, kFixedPairs

  // Valid from kPrepare on.
  std::span<SolverBody<double>> motion{};
  std::span<SymMat3d> inverse_inertia{};  // world, at the start of the step
  SweepRule<double> rule{};
  double h{};                 // s
  std::uint32_t sub_step{0};  // from 0
  double factor{1};           // kScale, kFinish

  // Valid from kBeginSubStep on: the ghosts of the border, by id of their bodies. If they may not supply energy, they
  // must do no work on bodies of this world.
  std::span<GhostState> ghosts{};
  bool ghosts_may_supply{true};
  // kEndSubStep: energy that the border may still supply to this world, and the work of joints to outside bodies in the
  // sub-step, which a stage sets.
  double border_left_J{0}, border_joints_J{0};
};

class StageTable {
 public:
  // [setup] `kStage`: a member function of `object` that takes the context. `object` must keep its address.
  template <auto kStage, class Object>
  void add(Phase phase, Object& object) noexcept {
    const bool fits = stages_[static_cast<std::uint32_t>(phase)].try_push(
        {[](void* self, StageContext& context) noexcept { (static_cast<Object*>(self)->*kStage)(context); }, &object});
    TACTUS_CHECK(fits, phase, kMaxStages);
  }
  bool has(Phase phase) const noexcept { return !stages_[static_cast<std::uint32_t>(phase)].empty(); }
  void run(Phase phase, StageContext& context) const noexcept {
    for (const Stage& stage : stages_[static_cast<std::uint32_t>(phase)]) stage.run(stage.object, context);
  }

 private:
  struct Stage {
    void (*run)(void* object, StageContext& context) noexcept {nullptr};
    void* object{nullptr};
  };
  std::array<FixedVector<Stage, kMaxStages>, kPhases> stages_{};
};

// Calls `f(slot)` for every body, shared with the executor where that saves time.
template <class F>
void for_each_slot(const StageContext& context, F&& f) noexcept {
  constexpr std::uint32_t kMin = 128;  // a body takes about 10 ns, handing work to another thread about 1 us
  context.executor.for_each_range(static_cast<std::uint32_t>(context.motion.size()), kMin,
                                  [&](std::uint32_t i, std::uint32_t end) noexcept {
                                    for (; i < end; ++i) f(i);
                                  });
}

// Base of effects without state between steps.
struct Stateless {
  void reset() noexcept {}
  void save(ByteWriter&) const noexcept {}
  bool restore(ByteReader&) noexcept { return true; }
  std::size_t save_size_bound() const noexcept { return 0; }
  void export_state(ByteWriter&, std::span<const Body>, std::span<const std::uint8_t>) const noexcept {}
  bool import_state(ByteReader&, std::span<const Body>, bool) noexcept { return true; }
};

}  // namespace tactus::physics
