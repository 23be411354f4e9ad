// The table of what a step does beside its contacts: stages of effects, by the phase of the step in which they run.
//
// A stage is a function and the room that it works in. The table is made once, from the effects that a scene uses; a
// phase is a loop over its stages, so an effect that is not used costs nothing: no branch, no call, no memory. Order
// within a phase is that of the list of effects. A stage sees all bodies at once and never a single contact's effect.
// Thread: filling [setup]; running [rt], by the owner of the World. Frame: world. Units: SI. Bound: kMostStages a
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
  kPairs = 0,         // pairs of moving bodies are known, by key: may take some out. Once a step
  kFixedPairs = 1,    // pairs (fixed slot, slot) are known: same
  kPrepare = 2,       // the solver has its bodies, not yet its rows
  kBeginSubStep = 3,  // velocities and poses are those that the last sub-step left
  kForces = 4,        // change velocities by what acts over h
  kWarmStart = 5,     // give the impulses of the last sub-step again; also where no sweep follows (a cut)
  kBiased = 6,        // before the contacts' biased sweep
  kMoved = 7,         // the bodies have moved by h
  kRelax = 8,         // before the contacts' relax sweep; more than once where there are more sweeps
  kScale = 9,         // after a warm start that no sweep follows: multiply its impulses by `factor`
  kKeep = 10,         // before the one relax sweep that corrects several sub-steps: note the impulses
  kFinish = 11,       // contacts hold the step's impulses; velocities may still be changed. Of impulses for the next
                      // step, `factor` of what came since kKeep counts; 1: all
};
inline constexpr std::uint32_t kPhases = 12;
inline constexpr std::uint32_t kMostStages = 16;

// What a stage sees. All by slot but contacts and fixed bodies.
struct StageContext {
  std::span<Body> bodies;  // as they were when the step began, until it has ended
  std::span<const Body> fixed_bodies;
  std::span<const std::uint8_t> held;  // 1: neither moves nor feels anything in this solve
  std::span<Contact> contacts;
  const StepSettings& settings;
  StepReport& report;
  Executor executor{};
  BoundedVector<SlotPair>* pairs{nullptr};  // kPairs, kFixedPairs

  // From kPrepare on.
  std::span<SolverBody<double>> motion{};
  std::span<SymMat3d> inverse_inertia{};  // world, at the start of the step
  SweepRule<double> rule{};
  double h{};                 // s
  std::uint32_t sub_step{0};  // from 0
  double factor{1};           // kScale, kFinish

  // From kBeginSubStep on: bodies of another world that this one knows by ghosts, by id. Where they may not give, they
  // do no work on bodies of this world.
  std::span<GhostState> ghosts{};
  bool ghosts_may_supply{true};
};

class StageTable {
 public:
  // [setup] `kStage`: a member function of the room, taking the context. The room stays where it is.
  template <auto kStage, class Room>
  void add(Phase phase, Room& room) noexcept {
    const bool fits = stages_[static_cast<std::uint32_t>(phase)].try_push(
        {[](void* self, StageContext& context) noexcept { (static_cast<Room*>(self)->*kStage)(context); }, &room});
    TACTUS_CHECK(fits, phase, kMostStages);
  }
  void run(Phase phase, StageContext& context) const noexcept {
    for (const Stage& stage : stages_[static_cast<std::uint32_t>(phase)]) stage.run(stage.room, context);
  }

 private:
  struct Stage {
    void (*run)(void* room, StageContext& context) noexcept {nullptr};
    void* room{nullptr};
  };
  std::array<FixedVector<Stage, kMostStages>, kPhases> stages_{};
};

// `f(slot)` for every body, shared where that pays.
template <class F>
void for_each_slot(const StageContext& context, F&& f) noexcept {
  constexpr std::uint32_t kFewest = 128;  // a body takes some ten nanoseconds, handing some over about a microsecond
  context.executor.for_each_range(static_cast<std::uint32_t>(context.motion.size()), kFewest,
                                  [&](std::uint32_t i, std::uint32_t end) noexcept {
                                    for (; i < end; ++i) f(i);
                                  });
}

// A room without a state of its own between steps inherits these.
struct Stateless {
  void reset() noexcept {}
  void save(ByteWriter&) const noexcept {}
  bool restore(ByteReader&) noexcept { return true; }
  std::size_t save_size_bound() const noexcept { return 0; }
  void export_state(ByteWriter&, std::span<const Body>, std::span<const std::uint8_t>) const noexcept {}
  bool import_state(ByteReader&, std::span<const Body>, bool) noexcept { return true; }
};

}  // namespace tactus::physics
