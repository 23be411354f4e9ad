// Holds back the warm start of what hangs together by contacts where it would raise the kinetic energy.
//
// A blow: the impulses that stop a body in one sub-step are the warm start of the next, and sweeps take them back only
// as fast as they travel through a stack; what they have not taken back by then pushes the bodies apart. With d the
// change of velocity that an island's impulses make, its energy changes by v.M.d + d.M.d / 2, v before it. Where that
// is positive, and most of d.M.d belongs to bodies in a blow, the island's impulses are scaled to where it is smallest.
// So a large heap that one body falls on keeps its warm start, on which it rests. Sweeps follow: where a warm start may
// rightly give energy (a moving kinematic body) no more than warmth is lost. An island: bodies that rows between moving
// bodies link; made anew in each step that needs it. Frame: world. Units: SI. Thread: construction [setup]; the rest
// [rt]. Bound: linear in bodies and rows.
#pragma once

#include <algorithm>
#include <span>

#include "rt/base/bounded_vector.h"
#include "rt/physics/islands.h"
#include "rt/physics/solver_body.h"

namespace tactus::physics {

// How `change` has changed a body's kinetic energy, `v` and `w` being those after it: linear + quadratic / 2, linear in
// the change's size and quadratic in it [J].
template <class T>
struct EnergyChange {
  T linear{}, quadratic{};

  void add(const SolverBody<T>& body, const SymMat3<T>& inverse_inertia, const Twist<T>& change) noexcept {
    const Vec3<T> momentum = (T(1) / body.inverse_mass) * change.linear,
                  turning = inverse(inverse_inertia) * change.angular;
    const T by_change = dot(momentum, change.linear) + dot(turning, change.angular);
    linear += dot(momentum, body.v) + dot(turning, body.w) - by_change, quadratic += by_change;
  }
  bool gains() const noexcept { return linear + T(0.5) * quadratic > T(0); }
  // Of the change: with that much of it the energy is smallest.
  T best_share() const noexcept { return gains() ? std::clamp(-linear / quadratic, T(0), T(1)) : T(1); }
};

// Do the impulses change the velocity by so much that it is a blow?
template <class T>
bool is_blow(const Twist<T>& change, T blow_m_per_s) noexcept {
  return norm_squared(change.linear) > blow_m_per_s * blow_m_per_s;
}

template <class T>
class EnergyGate {
 public:
  explicit EnergyGate(std::uint32_t bodies) : parents_(bodies), change_(bodies), share_(bodies) {}  // [setup]

  // Islands: first all bodies alone, then a link for every row. `knows_islands`: they are those of this step.
  void begin_step() noexcept { knows_islands_ = false; }
  bool knows_islands() const noexcept { return knows_islands_; }
  void begin_islands(std::uint32_t bodies) noexcept;
  void link(const SolverBodies<T>& bodies, std::uint32_t slot_a, std::uint32_t slot_b) noexcept;

  // `given`: what the warm start has just changed, by slot; a blow: by more than `blow_m_per_s`. Holds it back in the
  // bodies and in `given`; false: nowhere.
  bool hold_back(SolverBodies<T> bodies, std::span<Twist<T>> given, T blow_m_per_s) noexcept;
  // What is left of the impulses of a row.
  T share(const SolverBodies<T>& bodies, std::uint32_t slot_a, std::uint32_t slot_b) const noexcept {
    return share_[bodies.motion[slot_a].inverse_mass > T(0) ? slot_a : slot_b];
  }

 private:
  struct IslandChange {
    EnergyChange<T> all;  // only where there may be a blow
    T blow{}, shift{};    // J, of the quadratic part: of the bodies in a blow; of all, without their spin
    bool may_be_blow() const noexcept { return blow > T(0.5) * shift; }
    bool is_blow() const noexcept { return blow > T(0.5) * all.quadratic; }
  };

  BoundedVector<std::uint32_t> parents_;  // what the islands are kept in
  Islands islands_;
  BoundedVector<IslandChange> change_;  // by island
  BoundedVector<T> share_;              // by slot
  bool knows_islands_{false};
};

}  // namespace tactus::physics
