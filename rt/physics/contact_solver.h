// The kernels of the soft-step solver: what a sweep does to every contact, in the order of their keys.
//
// A row (point p, direction d) sees u = d . (v_b + w_b x r_b - v_a - w_a x r_a) and changes its impulse by
//   lambda' = max(0, lambda - m (mass_scale u + bias) - impulse_scale lambda),  m = 1 / (J M^-1 J^T).
// Separations within the step follow from the bodies' motion since its start: no collision between sub-steps.
// Friction belongs to the relax sweep alone, so that the bias never widens Coulomb's disk.
// Frame: world. Units: SI. Thread: construction [setup]; the rest [rt]. Bound: linear in points; as many contacts as
// given at construction. Source: Catto, soft-step (TGS-soft) solver.
#pragma once

#include <span>

#include "rt/base/bounded_vector.h"
#include "rt/physics/contact.h"
#include "rt/physics/softness.h"
#include "rt/physics/solver_body.h"
#include "rt/physics/step.h"

namespace tactus::physics {

template <class T>
struct ConstraintPoint {
  Vec3<T> r_a, r_b;  // m, from the centres, at the start of the step
  T separation{};    // m, less the part that r_a and r_b make (they turn with the bodies)
  T normal_mass{}, tangent_mass{};
  T normal_impulse{}, tangent_impulse[2]{};              // N s, of this sub-step
  T total_normal_impulse{}, total_tangent_impulse[2]{};  // N s, of the step so far
  T fill{};
};
static_assert(sizeof(ConstraintPoint<double>) == 128);

// The form of a contact that the sweeps stream over.
template <class T>
struct ContactConstraint {
  std::uint32_t a{0}, b{0}, count{0};  // slots; b is not read where B is fixed
  T friction{};
  Vec3<T> n, t1, t2;
  std::array<ConstraintPoint<T>, kMaxManifoldPoints> points;
};

// What all rows of a sweep share.
template <class T>
struct SweepRule {
  Softness<T> softness;
  T inverse_h{};       // 1/s
  T slop{};            // m
  T max_push_speed{};  // m/s

  static constexpr SweepRule of(const StepSettings<T>& s, T h) noexcept {
    return {Softness<T>::make(s.contact_hertz, s.contact_damping_ratio, h), T(1) / h, s.slop, s.max_push_speed};
  }
};

template <class T>
class ContactSolver {
 public:
  explicit ContactSolver(std::uint32_t contacts) : constraints_(contacts) {}  // [setup]

  void prepare(std::span<const Contact<T>> contacts, SolverBodies<T> bodies) noexcept;
  void warm_start(SolverBodies<T> bodies) const noexcept;
  void solve_biased(SolverBodies<T> bodies, const SweepRule<T>& rule) noexcept;
  // `last`: also adds the impulses to the totals of the step.
  void relax(SolverBodies<T> bodies, const SweepRule<T>& rule, bool friction, bool last) noexcept;
  // For a sub-step without a relax sweep: adds the impulses to the totals as they are.
  void add_to_totals() noexcept;
  void scale_impulses(T factor) noexcept;
  void store(std::span<Contact<T>> contacts) const noexcept;

 private:
  template <bool kBias, bool kFriction, bool kTotals>
  void sweep(SolverBodies<T> bodies, const SweepRule<T>& rule) noexcept;

  BoundedVector<ContactConstraint<T>> constraints_;
  std::uint32_t first_fixed_{0};  // contacts with fixed bodies come last
};

}  // namespace tactus::physics
