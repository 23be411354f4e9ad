// What a sweep does to a row: to as many contacts at once as V has lanes, none of which share a body.
//
// A contact works in a frame of its own: its plane's centre, t1, t2, n. The bodies' relative motion there is six
// numbers, their answer to a wrench there a 6 x 6 matrix W, computed once a step; so the points of a contact are solved
// one after the other on six numbers, and the bodies are read and written once per sweep. At the point (x, y) of the
// plane
//   u_n = v_n - x w_2 + y w_1,   u_1 = v_1 - y w_n,   u_2 = v_2 + x w_n
// and a row changes its impulse by
//   lambda' = max(0, lambda - m (mass_scale u + bias) - impulse_scale lambda),  m = 1 / (J M^-1 J^T).
// Points are taken at their place in the plane: for the normal rows that changes nothing, friction acts at most as far
// off as the points are from being coplanar. Gaps within the step follow from the bodies' motion since its start: no
// collision between sub-steps. Bodies move before the relax sweep, so it works them out and the biased sweep of the
// next sub-step finds them. Friction acts in the relax sweep, so that the bias never widens Coulomb's disk. With
// FrictionSweeps::kEvery it acts in the biased sweep too, before the normal rows, within the disks that the last relax
// sweep left: else what the bias moves creeps, and a wedge at 1.02 of its locking friction works itself loose. V is one
// number or a Wide: each lane has the bits that one number would have. Lanes beyond `used` have no mass and are not
// written back. Frame: world. Units: SI. Thread: [rt]. Bound: kMaxManifoldPoints points. Source: Catto, soft-step
// (TGS-soft) solver; rows of contacts without a common body, Tonge 2012.
#pragma once

#include <array>

#include "rt/physics/contact/body_lanes.h"
#include "rt/physics/contact/contact.h"
#include "rt/physics/contact/softness.h"
#include "rt/physics/step.h"

namespace tactus::physics {

// W by blocks: symmetric 3 x 3 in the order 00 11 22 01 02 12.
template <class V>
using SymBlock = std::array<V, 6>;

// First what every sweep streams over, then what only friction needs, then the books of the step.
template <class V>
struct alignas(64) ContactRow {
  static constexpr std::uint32_t kPoints = kMaxManifoldPoints;
  static constexpr int kWidth = kLanes<V>;

  std::uint32_t a[kWidth], b[kWidth];  // slots; b is not read where B is fixed
  std::uint32_t contact[kWidth];       // index among the contacts
  std::uint32_t used, points;          // lanes; the most points that a lane has
  Vec3<V> n, t1, t2;
  Vec3<V> c_a, c_b;  // m, the plane's centre from the bodies' centres, at the start of the step
  V inverse_mass_a, inverse_mass_b;
  SymMat3<V> inverse_inertia_a, inverse_inertia_b;
  SymBlock<V> w_normal;       // (v_n, w_1, w_2) per (f_n, m_1, m_2)
  V x[kPoints], y[kPoints];   // m, in the plane, along t1 and t2
  V separation[kPoints];      // m, at the start of the step
  V gap[kPoints];             // m, now: as the last relax sweep found it, at first the separation
  V normal_mass[kPoints];     // kg
  V normal_impulse[kPoints];  // N s, of this sub-step

  SymBlock<V> w_tangent;     // (v_1, v_2, w_n) per (f_1, f_2, m_n)
  std::array<V, 9> w_cross;  // (v_1, v_2, w_n) per (f_n, m_1, m_2), row by row
  V friction;
  V tangent_mass[kPoints];
  V tangent_impulse[2][kPoints];  // N s, of this sub-step

  V total_normal_impulse[kPoints], total_tangent_impulse[2][kPoints];  // N s, of the step so far
};

// What all rows of a sweep share.
template <class T>
struct SweepRule {
  Softness<T> softness;
  T inverse_h{};       // 1/s
  T slop{};            // m
  T max_push_speed{};  // m/s

  static constexpr SweepRule of(const StepSettings& s, T h) noexcept {
    return {Softness<T>::make(static_cast<T>(s.contact_hertz), static_cast<T>(s.contact_damping_ratio), h), T(1) / h,
            static_cast<T>(s.slop), static_cast<T>(s.max_push_speed)};
  }
};

// --- filling a row: every lane with a contact, then the whole. An empty lane must have been cleared before.
// The contacts' numbers are double, whatever the row's are.
template <class V>
void fill_lane(ContactRow<V>& row, int lane, std::uint32_t index, const Contact& contact,
               const SolverBodies<LaneOf<V>>& bodies) noexcept;
template <class V>
void complete(ContactRow<V>& row) noexcept;

// --- sweeps; kFixed: B is a fixed body in all lanes
template <bool kFixed, class V>
void warm_start(const ContactRow<V>& row, const SolverBodies<LaneOf<V>>& bodies) noexcept;
// kBias: the soft sweep; kTotals: also adds the impulses to the totals of the step.
// kBackwards: which way round the points are taken.
template <bool kBias, bool kFixed, bool kFriction, bool kTotals, bool kBackwards, class V>
void solve(ContactRow<V>& row, const SolverBodies<LaneOf<V>>& bodies, const SweepRule<LaneOf<V>>& rule) noexcept;

}  // namespace tactus::physics
