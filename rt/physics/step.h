// Settings and report of one step, and the predicate that may cut it. Units: SI. Thread: [any].
#pragma once

#include <cstdint>
#include <span>

#include "rt/base/spatial.h"

namespace tactus::physics {

// Asked at every sweep boundary; true: stop sweeping. A function pointer and its context, so that the step reads no
// clock. The default never cuts. [rt], must not block.
struct CutPredicate {
  bool (*fired)(void* context, std::uint32_t sweep) noexcept {nullptr};
  void* context{nullptr};

  bool operator()(std::uint32_t sweep) const noexcept { return fired != nullptr && fired(context, sweep); }
};

inline constexpr std::uint32_t kNeverCut = 0xffffffffu;

// Which sweeps of a sub-step solve friction. kRelax: the last relax sweep. kEvery: the biased sweep too, so that what
// it moves does not creep: a wedge at its locking friction holds. kAuto: kEvery if there are two relax sweeps or more.
// Sweeps between the two do not solve friction (contact_row.h).
enum class FrictionSweeps : std::uint8_t { kAuto, kRelax, kEvery };

constexpr FrictionSweeps resolve(FrictionSweeps asked, std::uint32_t relax_sweeps) noexcept {
  if (asked != FrictionSweeps::kAuto) return asked;
  return relax_sweeps > 1 ? FrictionSweeps::kEvery : FrictionSweeps::kRelax;
}

// Constant during a run except sub_steps, which the governor chooses before each tick.
struct StepSettings {
  double dt{1e-3};                // s: the whole step
  std::uint32_t sub_steps{4};     // h = dt / sub_steps
  std::uint32_t relax_sweeps{1};  // per sub-step
  double contact_hertz{250.0};    // Hz, the same in both worlds; at most 0.25 / h
  double contact_damping_ratio{10.0};
  double max_push_speed{0.25};  // m/s: greatest speed at which an overlap is corrected
  double slop{1e-5};            // m: overlap that is not corrected
  double min_margin{5e-4};      // m: points are found up to this distance, or up to what dt may close if that is more
  double max_margin{2e-2};      // m: limit of what dt may close, for the margin
  // m: manifolds of boxes and hulls are reused until their surfaces have moved by this; 0: never reused.
  double recycle_tolerance_m{5e-5};
  Vec3d gravity{};      // m/s^2
  bool friction{true};  // effect friction: Coulomb friction
  FrictionSweeps friction_sweeps{FrictionSweeps::kAuto};
  bool gyroscopic{true};  // effect gyroscopic: the gyroscopic term
};

// Extra margin with which a manifold is searched so that it can be reused [m]: covers the motion of its bodies, and an
// increase of their speed, until the tolerance is used up.
constexpr double carry_over_margin(const StepSettings& settings) noexcept { return 2.0 * settings.recycle_tolerance_m; }

// Bodies that no pair links to the others and for which fewer sub-steps suffice.
struct CoarseRegion {
  std::span<const std::uint8_t> bodies;  // by slot, 1: coarse; empty: no body is coarse
  std::uint32_t sub_steps{0};
};

struct StepReport {
  std::uint32_t capacity_bits{0};      // CapacityBit
  std::uint32_t dropped{0};            // pairs and contacts left out
  std::uint32_t pairs{0};              // given to narrow phase
  std::uint32_t searched{0};           // pairs whose shapes were compared because no manifold could be reused
  std::uint32_t comparisons{0};        // work of the searched pairs, in comparisons of two boxes
  std::uint32_t joints{0};             // solved
  std::uint32_t contacts{0};           // manifolds solved
  std::uint32_t points{0};             // points solved
  std::uint32_t cut_sweep{kNeverCut};  // sweep at which the cut fired
  double deepest_m{};                  // largest overlap at the start of the step [m]
  std::uint32_t broken_joints{0};      // joints that broke in this step
  double border_joints_J{};            // J: work of joints to bodies of another world, done on this world's bodies
  double push_out_J{};                 // J: PushOut::work_J; of a world with ghosts, else 0
  // N, N m about the proxy's centre: what the hand receives beside the coupling's wrench (effects texture, transients).
  Wrenchd hand_wrench{};
};

}  // namespace tactus::physics
