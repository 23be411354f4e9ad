// The rows of contacts and the sweeps over them: each row holds as many contacts as V has lanes, none of which share a
// body.
//
// A contact is solved in a frame of its own: the centre of its plane, t1, t2, n. The bodies' relative motion there is
// six numbers, and its response to a wrench there a 6 x 6 matrix W, computed once a step. So the points of a contact
// are solved one after the other on six numbers, and the bodies are read and written once per sweep.
// At the point (x, y) of the plane
//  u_n = v_n - x w_2 + y w_1,   u_1 = v_1 - y w_n,   u_2 = v_2 + x w_n
// and a row changes its impulse by
//  lambda' = max(0, lambda - m (mass_scale u + bias) - impulse_scale lambda),  m = 1 / (J M^-1 J^T).
// A cylinder, a cone or a capsule, touched on its side or rim: when it rotates about its axis, the contact line
// stays in place but consists of other points of the body. So of a rotation by the angle t only the term linear in t
// changes the gap. The term of second order, c (1 - cos t), would lift the points off the ground within the step: at
// 5 m/s with a radius of 30 mm by 0.4 mm in 1 ms. The contact would then press in a part of the step only, and the
// sweeps would end before the two ends of the line are loaded alike: a cylinder that rolled straight turned by 80
// degrees in 3 s (2026-11-27). A capsule has the same rule; with that of the ball for the centres of its ends six of
// 8,000 random worlds gained energy by an impact that spins it by more than half a radian in a sub-step, with this
// one 31 of 80,000, with points that rotate with it 32 (2026-11-29).
// A ball: a rotation about its centre does not change the gap, which is the gap of the centre (`round` behind the
// point along the normal) less the radius. With points that rotate with the body the gap would grow by r (1 - cos
// t): a ball of 30 mm at 5 m/s sank by 0.1 mm in steps of 1 ms and by 7 mm in steps of 8 ms (2026-11-27).
// An overlap is corrected at max_push_speed at most (softness.h).
// Points are projected onto the plane: this is exact for the normal rows; friction acts off its point by at most the
// points' deviation from the plane. Gaps within the step follow from the bodies' motion since its start: no narrow
// phase between sub-steps. Bodies move before the relax sweep, so that sweep updates the gaps, and the biased sweep
// of the next sub-step uses them.
// Friction is solved in the last relax sweep, so that the bias never enlarges the Coulomb disk. With
// FrictionSweeps::kEvery it is also solved in the biased sweep, before the normal rows, within the disks of the last
// relax sweep; otherwise the motion that the bias causes accumulates as creep, and a wedge at 1.02 of its locking
// friction comes loose. In the sweeps between them it must not be solved: then friction is solved as often as the
// normals, and at hertz = 0.25 / h the sway of tall stacks grows; a pyramid of base 40 walked by 170 mm in 8 s, and
// by 0.1 mm since (2026-11-30).
// A body that rotates about the contact's normal, such as a turntable, carries the contact around in the step. So the
// plane's centre is that of the middle of the step: then the velocity there is along the chord of the arc. With the
// centre of the start it points outward by half the angle of a step, and what lies on a turntable of w rad/s drifts
// outward as exp(w^2 dt t / 2). Measured at 3 rad/s: 0.008 % a second instead of 0.45 in steps of 1 ms; 1.8 instead of
// 4.5 in steps of 10 ms, where friction needs half of the step to turn the velocity (2026-11-30).
// V is a number or a Wide: each lane has the same bits as the scalar code. Lanes beyond `used` have no mass and are not
// written back.
// Frame: world. Units: SI. Thread: [rt]. Bound: kMaxManifoldPoints points. Source: Catto, soft-step (TGS-soft) solver;
// rows of contacts without a common body, Tonge 2012.
#pragma once

#include <array>

#include "rt/physics/contact/body_lanes.h"
#include "rt/physics/contact/contact.h"
#include "rt/physics/contact/row_points.h"
#include "rt/physics/step.h"

namespace tactus::physics {

// In memory order: what every sweep reads, then what only friction needs, then the totals of the step.
template <class V>
struct alignas(64) ContactRow {
  static constexpr std::uint32_t kPoints = kMaxManifoldPoints;
  static constexpr int kWidth = kLanes<V>;

  std::uint32_t a[kWidth], b[kWidth];  // slots; b is not read if B is fixed
  std::uint32_t contact[kWidth];       // index among the contacts
  std::uint32_t used, points;          // lanes in use; largest number of points of a lane
  std::uint16_t any_shared;            // 1 if a lane's `share` is above 1
  std::uint16_t any_round;             // 1 if a lane has a round side; otherwise round_a and round_b are not set
  std::uint32_t rolling;               // bit 2 lane: A is touched on a surface of revolution; bit 2 lane + 1: B is
  Vec3<V> n, t1, t2;
  Vec3<V> c_a, c_b;          // m, the plane's centre from the bodies' centres, in the middle of the step
  Vec3<V> start_a, start_b;  // m, the same at the start of the step
  V inverse_mass_a, inverse_mass_b;
  SymMat3<V> inverse_inertia_a, inverse_inertia_b;
  SymBlock<V> w_normal;       // (v_n, w_1, w_2) per (f_n, m_1, m_2)
  V x[kPoints], y[kPoints];   // m, in the plane, along t1 and t2
  V separation[kPoints];      // m, at the start of the step
  V gap[kPoints];             // m, as of the last relax sweep; at first the separation
  V share;                    // contacts that the same two bodies' points fill: 1 but for compounds (softness.h)
  V normal_mass[kPoints];     // kg
  V normal_impulse[kPoints];  // N s, of this sub-step

  SymBlock<V> w_tangent;     // (v_1, v_2, w_n) per (f_1, f_2, m_n)
  std::array<V, 9> w_cross;  // (v_1, v_2, w_n) per (f_n, m_1, m_2), row by row
  V friction;
  V tangent_mass[kPoints];
  V tangent_impulse[2][kPoints];  // N s, of this sub-step

  V total_normal_impulse[kPoints], total_tangent_impulse[2][kPoints];  // N s, of the step so far
  V round_a, round_b;  // m, from the points back to the centre of a ball, along the normal; else 0
};

// Constants shared by all rows of a sweep.
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

// Stores an impulse for the next step: `kept` plus `share` of the change (ContactSolver::store).
inline void store_impulse(double& kept, double now, double share) noexcept {
  kept = share == 1.0 ? now : kept + share * (now - kept);
}

// --- filling a row: every lane with a contact, then `complete`. A row with empty lanes must be cleared before.
// The contacts are in double, whatever V is. The lane's `share` is the caller's to set. `dt` [s]: of the step.
template <class V>
void fill_lane(ContactRow<V>& row, int lane, std::uint32_t index, const Contact& contact,
               const SolverBodies<LaneOf<V>>& bodies, double dt) noexcept;
template <class V>
void complete(ContactRow<V>& row) noexcept;

// The order in which a sweep takes the points of a contact; false: first to last, true: last to first.
struct PointOrder {
  bool normals_backwards{false}, friction_backwards{false};
};

// --- sweeps; kFixed: B is a fixed body in all lanes
template <bool kFixed, class V>
void warm_start(const ContactRow<V>& row, const SolverBodies<LaneOf<V>>& bodies) noexcept;
// kBias: the soft sweep; kTotals: also adds the impulses to the totals of the step.
template <bool kBias, bool kFixed, bool kFriction, bool kTotals, class V>
void solve(ContactRow<V>& row, const SolverBodies<LaneOf<V>>& bodies, const SweepRule<LaneOf<V>>& rule,
           PointOrder order) noexcept;

}  // namespace tactus::physics
