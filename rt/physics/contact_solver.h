// The kernels of the soft-step solver: what a sweep does to every contact, in the order of their keys.
//
// A contact works in a frame of its own: its plane's centre, t1, t2, n. The bodies' relative motion there is six
// numbers, their answer to a wrench there a 6 x 6 matrix W, computed once a step; so the points of a contact are solved
// one after the other on six numbers, and the bodies are read and written once per sweep. At the point (x, y) of the
// plane
//   u_n = v_n - x w_2 + y w_1,   u_1 = v_1 - y w_n,   u_2 = v_2 + x w_n
// and a row changes its impulse by
//   lambda' = max(0, lambda - m (mass_scale u + bias) - impulse_scale lambda),  m = 1 / (J M^-1 J^T).
// Points are taken at their place in the plane: for the normal rows that changes nothing, friction acts at most as far
// off as the points are from being coplanar. Separations within the step follow from the bodies' motion since its
// start: no collision between sub-steps. Friction belongs to the relax sweep alone, so that the bias never widens
// Coulomb's disk. Frame: world. Units: SI. Thread: construction [setup]; the rest [rt]. Bound: linear in points; as
// many contacts as given at construction. Source: Catto, soft-step (TGS-soft) solver.
#pragma once

#include <array>
#include <span>

#include "rt/base/bounded_vector.h"
#include "rt/physics/contact.h"
#include "rt/physics/softness.h"
#include "rt/physics/solver_body.h"
#include "rt/physics/step.h"

namespace tactus::physics {

// W by blocks: symmetric 3 x 3 in the order 00 11 22 01 02 12.
template <class T>
using SymBlock = std::array<T, 6>;

// The form of a contact that the sweeps stream over: first what every sweep needs, then what only friction needs.
template <class T>
struct alignas(64) ContactConstraint {
  static constexpr std::uint32_t kPoints = kMaxManifoldPoints;

  std::uint32_t a{0}, b{0}, count{0};  // slots; b is not read where B is fixed
  Vec3<T> n, t1, t2;
  Vec3<T> c_a, c_b;           // m, the plane's centre from the bodies' centres, at the start of the step
  SymBlock<T> w_normal;       // (v_n, w_1, w_2) per (f_n, m_1, m_2)
  T x[kPoints], y[kPoints];   // m, in the plane, along t1 and t2
  T separation[kPoints];      // m, at the start of the step
  T normal_mass[kPoints];     // kg
  T normal_impulse[kPoints];  // N s, of this sub-step

  SymBlock<T> w_tangent;     // (v_1, v_2, w_n) per (f_1, f_2, m_n)
  std::array<T, 9> w_cross;  // (v_1, v_2, w_n) per (f_n, m_1, m_2), row by row
  T friction{};
  T tangent_mass[kPoints];
  T tangent_impulse[2][kPoints];                                       // N s, of this sub-step
  T total_normal_impulse[kPoints], total_tangent_impulse[2][kPoints];  // N s, of the step so far
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
  // Impulses and totals, for the next step. `share`: see Solver. Below 1 the impulses stored are those of the last
  // keep_impulses, and that share of what came since.
  void store(std::span<Contact<T>> contacts, T share) const noexcept;
  void keep_impulses(std::span<Contact<T>> contacts) const noexcept { store_impulses(contacts, T(1)); }

 private:
  void store_impulses(std::span<Contact<T>> contacts, T share) const noexcept;
  template <bool kBias, bool kFriction, bool kTotals>
  void sweep(SolverBodies<T> bodies, const SweepRule<T>& rule) noexcept;

  BoundedVector<ContactConstraint<T>> constraints_;
  std::uint32_t first_fixed_{0};  // contacts with fixed bodies come last
};

}  // namespace tactus::physics
