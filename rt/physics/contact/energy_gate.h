// Limits the warm start of an island of contacts where it would raise the kinetic energy after an impact.
//
// Impact: the impulses that stop a body in one sub-step warm-start the next, and the sweeps remove them only as fast as
// corrections travel through a stack; the rest pushes the bodies apart. With d the change of velocity by an island's
// impulses, its energy changes by v.M.d + d.M.d / 2, v before it. If that is positive, and most of d.M.d belongs to
// bodies with an impact, the island's impulses are scaled to where the energy is smallest. So a large heap on which one
// body falls keeps the warm start that supports its weight. Where a warm start rightly adds energy (a moving kinematic
// body), the scaling makes only the warm start worse, because sweeps follow. Island: bodies linked by rows between
// moving bodies; recomputed in each step that needs it.
// Frame: world. Units: SI. Thread: construction [setup]; the rest [rt]. Bound: linear in bodies and rows.
#pragma once

#include <algorithm>
#include <span>

#include "rt/base/bounded_vector.h"
#include "rt/physics/islands.h"
#include "rt/physics/solver_body.h"

namespace tactus::physics {

// Change of a body's kinetic energy by `change` [J], with `v` and `w` after it: linear + quadratic / 2, where `linear`
// scales with the size of the change and `quadratic` with its square.
template <class T>
struct EnergyChange {
  T linear{}, quadratic{};

  void add(const SolverBody<T>& body, const SymMat3<T>& inverse_inertia, const Twist<T>& change) noexcept {
    const Vec3<T> momentum = (T(1) / body.inverse_mass) * change.linear,
                  angular_momentum = inverse(inverse_inertia) * change.angular;
    const T by_change = dot(momentum, change.linear) + dot(angular_momentum, change.angular);
    linear += dot(momentum, body.v) + dot(angular_momentum, body.w) - by_change;
    quadratic += by_change;
  }
  bool gains() const noexcept { return linear + T(0.5) * quadratic > T(0); }
  // Share of the change at which the energy is smallest.
  T best_share() const noexcept { return gains() ? std::clamp(-linear / quadratic, T(0), T(1)) : T(1); }
};

// True if the impulses change the velocity by so much that it is an impact.
template <class T>
bool is_impact(const Twist<T>& change, T impact_m_per_s) noexcept {
  return norm_squared(change.linear) > impact_m_per_s * impact_m_per_s;
}

template <class T>
class EnergyGate {
 public:
  explicit EnergyGate(std::uint32_t bodies) : parents_(bodies), change_(bodies), share_(bodies) {}  // [setup]

  // Islands: begin_islands makes every body an island of its own; then link every row. `knows_islands`: true if that
  // was done in this step.
  void begin_step() noexcept { knows_islands_ = false; }
  bool knows_islands() const noexcept { return knows_islands_; }
  void begin_islands(std::uint32_t bodies) noexcept;
  void link(const SolverBodies<T>& bodies, std::uint32_t slot_a, std::uint32_t slot_b) noexcept;

  // `given`: the change of velocity by the warm start, by slot; an impact changes it by more than `impact_m_per_s`.
  // Scales the change in the bodies and in `given`; returns false if nothing was scaled.
  bool hold_back(SolverBodies<T> bodies, std::span<Twist<T>> given, T impact_m_per_s) noexcept;
  // Share by which a row's impulses are scaled.
  T share(const SolverBodies<T>& bodies, std::uint32_t slot_a, std::uint32_t slot_b) const noexcept {
    return share_[bodies.motion[slot_a].inverse_mass > T(0) ? slot_a : slot_b];
  }

 private:
  struct IslandChange {
    EnergyChange<T> all;  // only if there may be an impact
    T impact{}, shift{};  // J, quadratic part: of the bodies with an impact; of all bodies, without rotation
    bool may_be_impact() const noexcept { return impact > T(0.5) * shift; }
    bool is_impact() const noexcept { return impact > T(0.5) * all.quadratic; }
  };

  BoundedVector<std::uint32_t> parents_;  // storage of islands_
  Islands islands_;
  BoundedVector<IslandChange> change_;  // by island
  BoundedVector<T> share_;              // by slot
  bool knows_islands_{false};
};

}  // namespace tactus::physics
