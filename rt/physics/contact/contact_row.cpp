#include "rt/physics/contact/contact_row.h"

namespace tactus::physics {
namespace {

// Change of the gap by the bodies' motion since the start of the step: gap + x slope_1 + y slope_2.
template <class V>
struct GapChange {
  V gap, slope_1, slope_2;
};

// The part of the inverse rotation's change of `n` that is of second order: absent where a body rolls. `side`: 0 A, 1
// B.
template <class V>
Vec3<V> second_order_turn(const ContactRow<V>& c, const Quat<V>& turned, std::uint32_t side) noexcept {
  V rolls(0);
  for (int lane = 0; lane < kLanes<V>; ++lane)
    set_lane(rolls, lane, static_cast<LaneOf<V>>(c.rolling >> (2 * static_cast<std::uint32_t>(lane) + side) & 1u));
  return (V(2) * rolls) * cross(turned.vec(), cross(turned.vec(), c.n));
}

template <bool kFixed, class V>
TACTUS_INLINE GapChange<V> gap_change(const ContactRow<V>& c, const BodyLanes<V>& a, const BodyLanes<V>& b) noexcept {
  // n . (R r - r) = (R^T n - n) . r: rotates the normal back once instead of every point forward.
  Vec3<V> turn_a = rotate_inverse(a.delta_rotation, c.n) - c.n;
  if (c.rolling != 0) turn_a -= second_order_turn(c, a.delta_rotation, 0);
  V gap = -dot(c.n, a.delta_position) - dot(turn_a, c.start_a);
  if (c.any_round != 0) gap += c.round_a * dot(turn_a, c.n);
  Vec3<V> turn = -turn_a;
  if constexpr (!kFixed) {
    Vec3<V> turn_b = rotate_inverse(b.delta_rotation, c.n) - c.n;
    if (c.rolling != 0) turn_b -= second_order_turn(c, b.delta_rotation, 1);
    gap += dot(c.n, b.delta_position) + dot(turn_b, c.start_b);
    if (c.any_round != 0) gap += c.round_b * dot(turn_b, c.n);
    turn += turn_b;
  }
  return {gap, dot(turn, c.t1), dot(turn, c.t2)};
}

// Updates the points' gaps after the bodies have moved.
template <bool kFixed, class V>
TACTUS_INLINE void update_gaps(ContactRow<V>& c, const BodyLanes<V>& a, const BodyLanes<V>& b) noexcept {
  const GapChange<V> moved = gap_change<kFixed>(c, a, b);
  for (std::uint32_t i = 0; i < c.points; ++i)
    c.gap[i] = c.separation[i] + moved.gap + c.x[i] * moved.slope_1 + c.y[i] * moved.slope_2;
}

// The softness of a contact's points in the biased sweep (softness.h).
template <class V>
TACTUS_INLINE PointSoftness<V> softness_of(const ContactRow<V>& c, const SweepRule<LaneOf<V>>& rule) noexcept {
  PointSoftness<V> soft{V(rule.softness.mass_scale), V(rule.softness.impulse_scale),
                        V(rule.softness.mass_scale * rule.softness.bias_rate), V(-rule.max_push_speed)};
  if (c.any_shared != 0) {
    const auto shared = c.share > V(1);
    const V whole = soft.mass_scale + c.share * soft.impulse_scale;
    soft.mass_scale = select(shared, soft.mass_scale / whole, soft.mass_scale);
    soft.impulse_scale = select(shared, c.share * soft.impulse_scale / whole, soft.impulse_scale);
    soft.bias_rate = select(shared, soft.mass_scale * V(rule.softness.bias_rate), soft.bias_rate);
  }
  return soft;
}

// Clamps the friction of the lanes in `which` to the disks of normal impulses that have just become smaller.
template <class Mask, class V>
TangentPart<V> shrink_friction(ContactRow<V>& c, Mask which) noexcept {
  TangentPart<V> sum;
  for (std::uint32_t i = 0; i < c.points; ++i) {
    V next_1 = c.tangent_impulse[0][i], next_2 = c.tangent_impulse[1][i];
    clamp_to_disk(next_1, next_2, c.friction * c.normal_impulse[i]);
    next_1 = select(which, next_1, c.tangent_impulse[0][i]);
    next_2 = select(which, next_2, c.tangent_impulse[1][i]);
    const V f1 = next_1 - c.tangent_impulse[0][i], f2 = next_2 - c.tangent_impulse[1][i];
    c.tangent_impulse[0][i] = next_1;
    c.tangent_impulse[1][i] = next_2;
    sum.t1 += f1;
    sum.t2 += f2;
    sum.mn += c.x[i] * f2 - c.y[i] * f1;
  }
  return sum;
}

// True if the biased sweep removed more than half of the contact's normal impulse.
template <class V>
auto lost_most_of_its_impulse(const ContactRow<V>& c, V change) noexcept {
  V left(0);
  for (std::uint32_t i = 0; i < c.points; ++i) left += c.normal_impulse[i];
  return both(change<V(0), -change> left);
}

// Applies the impulse `p` at the plane's centre and the moment `m` to B, the opposite to A.
template <bool kFixed, class V>
TACTUS_INLINE void apply(const ContactRow<V>& c, BodyLanes<V>& a, BodyLanes<V>& b, const Vec3<V>& p,
                         const Vec3<V>& m) noexcept {
  a.v -= c.inverse_mass_a * p;
  a.w -= c.inverse_inertia_a * (cross(c.c_a, p) + m);
  if constexpr (!kFixed) {
    b.v += c.inverse_mass_b * p;
    b.w += c.inverse_inertia_b * (cross(c.c_b, p) + m);
  }
}

// The bodies of both sides; B is not read if it is fixed.
template <class V>
struct Sides {
  BodyLanes<V> a, b;
};

// kPoses: also reads the bodies' motion since the start of the step.
template <bool kFixed, bool kPoses, class V>
TACTUS_INLINE Sides<V> gather(const ContactRow<V>& row, const SolverBodies<LaneOf<V>>& bodies) noexcept {
  const auto read = [&](const std::uint32_t(&slots)[kLanes<V>]) noexcept {
    if constexpr (kPoses) return BodyLanes<V>::read(bodies.motion.data(), slots);
    return BodyLanes<V>::read_velocities(bodies.motion.data(), slots);
  };
  if constexpr (kFixed) return {read(row.a), {}};
  return {read(row.a), read(row.b)};
}

template <bool kFixed, class V>
TACTUS_INLINE void scatter(const ContactRow<V>& row, const SolverBodies<LaneOf<V>>& bodies, const BodyLanes<V>& a,
                           const BodyLanes<V>& b) noexcept {
  a.write_velocities(bodies.motion.data(), row.a, row.used);
  if constexpr (!kFixed) b.write_velocities(bodies.motion.data(), row.b, row.used);
}

// Fills W: the change of the relative motion at the plane's centre by a unit impulse or moment there.
template <class V>
void fill_mobility(ContactRow<V>& c) noexcept {
  struct Answer {
    Vec3<V> v, w;
  };
  const auto answer_of = [&](const Vec3<V>& p, const Vec3<V>& m) noexcept {
    const Vec3<V> w_a = c.inverse_inertia_a * (cross(c.c_a, p) + m), w_b = c.inverse_inertia_b * (cross(c.c_b, p) + m);
    return Answer{(c.inverse_mass_a + c.inverse_mass_b) * p + cross(w_a, c.c_a) + cross(w_b, c.c_b), w_a + w_b};
  };
  const Mobility<V> w = mobility_of(c.n, c.t1, c.t2, answer_of);
  c.w_normal = w.normal;
  c.w_tangent = w.tangent;
  c.w_cross = w.cross;
}

// `v` rotated by `angle` [rad] about the unit vector `n`, by Cayley's formula with tan(angle / 2) = angle / 2: exact in
// length, and to the third order in the angle.
template <class V>
TACTUS_INLINE Vec3<V> rotated_about(const Vec3<V>& n, V angle, const Vec3<V>& v) noexcept {
  const V t = V(0.5f) * angle;
  const Vec3<V> once = t * cross(n, v);
  return v + V(2) / (V(1) + t * t) * (once + t * cross(n, once));
}

}  // namespace

template <class V>
void fill_lane(ContactRow<V>& row, int lane, std::uint32_t index, const Contact& contact,
               const SolverBodies<LaneOf<V>>& bodies, double dt) noexcept {
  using T = LaneOf<V>;
  const auto as_lane = [](double x) noexcept { return static_cast<T>(x); };
  row.a[lane] = contact.slot_a;
  row.b[lane] = contact.b_fixed ? contact.slot_a : contact.slot_b;
  row.contact[lane] = index;
  row.rolling |= ((contact.rolls_a ? 1u : 0u) | (contact.rolls_b ? 2u : 0u)) << (2 * static_cast<std::uint32_t>(lane));
  if (contact.round_a > 0.0 || contact.round_b > 0.0) {
    if (row.any_round == 0) row.round_a = row.round_b = V(0);
    row.any_round = 1;
    set_lane(row.round_a, lane, as_lane(contact.round_a));
    set_lane(row.round_b, lane, as_lane(contact.round_b));
  }
  set_lane(row.n, lane, number_cast<T>(contact.normal));
  set_lane(row.friction, lane, as_lane(contact.friction));
  set_lane(row.inverse_mass_a, lane, bodies.motion[contact.slot_a].inverse_mass);
  set_lane(row.inverse_inertia_a, lane, bodies.inverse_inertia[contact.slot_a]);
  set_lane(row.inverse_mass_b, lane, contact.b_fixed ? T(0) : bodies.motion[contact.slot_b].inverse_mass);
  set_lane(row.inverse_inertia_b, lane, contact.b_fixed ? SymMat3<T>{} : bodies.inverse_inertia[contact.slot_b]);

  Vec3d c_a, c_b;
  for (std::uint32_t i = 0; i < contact.count; ++i) {
    c_a += contact.points[i].from_a;
    c_b += contact.points[i].from_b;
  }
  c_a *= 1.0 / static_cast<double>(contact.count);
  c_b *= 1.0 / static_cast<double>(contact.count);
  const auto turn_in_half_step = [&](std::uint32_t slot) noexcept {
    return static_cast<T>(0.5 * dt) * dot(number_cast<T>(contact.normal), bodies.motion[slot].w);
  };
  set_lane(row.start_a, lane, number_cast<T>(c_a));
  set_lane(row.start_b, lane, number_cast<T>(c_b));
  // Until `complete` the centres hold the angle by which the bodies turn about the normal in half of the step.
  set_lane(row.c_a.x, lane, turn_in_half_step(contact.slot_a));
  set_lane(row.c_b.x, lane, contact.b_fixed ? T(0) : turn_in_half_step(contact.slot_b));
  for (std::uint32_t i = 0; i < ContactRow<V>::kPoints; ++i) {
    const ContactPoint& from = contact.points[i < contact.count ? i : 0];
    const bool there = i < contact.count && !from.redundant;
    // Until `complete` the totals hold the points' positions relative to the centre; an unused point has mass 0.
    set_lane(row.total_normal_impulse[i], lane, as_lane(from.from_a.x - c_a.x));
    set_lane(row.total_tangent_impulse[0][i], lane, as_lane(from.from_a.y - c_a.y));
    set_lane(row.total_tangent_impulse[1][i], lane, as_lane(from.from_a.z - c_a.z));
    set_lane(row.normal_mass[i], lane, there ? T(1) : T(0));
    set_lane(row.separation[i], lane, as_lane(from.separation));
    set_lane(row.normal_impulse[i], lane, there ? as_lane(from.normal_impulse) : T(0));
    set_lane(row.tangent_impulse[0][i], lane, there ? as_lane(from.tangent_impulse[0]) : T(0));
    set_lane(row.tangent_impulse[1][i], lane, there ? as_lane(from.tangent_impulse[1]) : T(0));
  }
  row.points = row.points < contact.count ? contact.count : row.points;
}

template <class V>
void complete(ContactRow<V>& c) noexcept {
  const auto [t1, t2] = tangents_of(c.n);
  c.t1 = t1;
  c.t2 = t2;
  c.c_a = rotated_about(c.n, c.c_a.x, c.start_a);
  c.c_b = rotated_about(c.n, c.c_b.x, c.start_b);
  fill_mobility(c);
  const V zero(0);
  for (std::uint32_t i = 0; i < c.points; ++i) {
    const Vec3<V> place{c.total_normal_impulse[i], c.total_tangent_impulse[0][i], c.total_tangent_impulse[1][i]};
    const V x = dot(place, c.t1), y = dot(place, c.t2);
    const auto there = c.normal_mass[i] > zero;
    c.x[i] = x;
    c.y[i] = y;
    c.gap[i] = c.separation[i];
    c.normal_mass[i] = select(there, invert_or_zero(normal_mobility(c.w_normal, x, y)), zero);
    c.tangent_mass[i] = select(there, tangent_mass_at(c.w_tangent, x, y), zero);
    c.total_normal_impulse[i] = c.total_tangent_impulse[0][i] = c.total_tangent_impulse[1][i] = zero;
  }
}

template <bool kFixed, class V>
void warm_start(const ContactRow<V>& c, const SolverBodies<LaneOf<V>>& bodies) noexcept {
  const PointSum<V> sum = sum_of_points<V>(c);
  auto [a, b] = gather<kFixed, false>(c, bodies);
  apply<kFixed>(c, a, b, sum.impulse(c.n, c.t1, c.t2), sum.moment(c.n, c.t1, c.t2));
  scatter<kFixed>(c, bodies, a, b);
}

template <bool kBias, bool kFixed, bool kFriction, bool kTotals, class V>
void solve(ContactRow<V>& c, const SolverBodies<LaneOf<V>>& bodies, const SweepRule<LaneOf<V>>& rule,
           PointOrder order) noexcept {
  auto [a, b] = gather<kFixed, !kBias>(c, bodies);
  if constexpr (!kBias) update_gaps<kFixed>(c, a, b);
  Vec3<V> v = -(a.v + cross(a.w, c.c_a)), w = -a.w;
  if constexpr (!kFixed) {
    v += b.v + cross(b.w, c.c_b);
    w += b.w;
  }

  NormalPart<V> normal_motion{dot(c.n, v), dot(c.t1, w), dot(c.t2, w)};
  TangentPart<V> held;
  if constexpr (kBias && kFriction) {
    const std::array<V, 9>& k = c.w_cross;
    held = solve_friction<false>(c, TangentPart<V>{dot(c.t1, v), dot(c.t2, v), dot(c.n, w)}, order.friction_backwards);
    normal_motion.n += k[0] * held.t1 + k[3] * held.t2 + k[6] * held.mn;
    normal_motion.m1 += k[1] * held.t1 + k[4] * held.t2 + k[7] * held.mn;
    normal_motion.m2 += k[2] * held.t1 + k[5] * held.t2 + k[8] * held.mn;
  }
  PointSoftness<V> soft;
  if constexpr (kBias) soft = softness_of(c, rule);
  const NormalPart<V> pressed =
      solve_normals<kBias, kTotals>(c, normal_motion, rule, order.normals_backwards,
                                    [&](std::uint32_t) noexcept -> const PointSoftness<V>& { return soft; });
  Vec3<V> p = pressed.n * c.n, m = pressed.m1 * c.t1 + pressed.m2 * c.t2;
  if constexpr (kBias && kFriction) {
    p += held.t1 * c.t1 + held.t2 * c.t2;
    m += held.mn * c.n;
  }
  if constexpr (kFriction && !kBias) {
    const TangentPart<V> rubbed =
        solve_friction<kTotals>(c, tangent_motion_after(c, v, w, pressed), order.friction_backwards);
    p += rubbed.t1 * c.t1 + rubbed.t2 * c.t2;
    m += rubbed.mn * c.n;
  } else if constexpr (kBias) {
    // The warm start repeated the impulse of an impact. Its friction must be removed together with its normal impulse:
    // if it is left to the relax sweep, the contacts solved before this one react to it, and the energy stays.
    const auto lost = lost_most_of_its_impulse(c, pressed.n);
    if (any(lost)) {
      const TangentPart<V> rubbed = shrink_friction(c, lost);
      p = select(lost, p + rubbed.t1 * c.t1 + rubbed.t2 * c.t2, p);
      m = select(lost, m + rubbed.mn * c.n, m);
    }
  }
  apply<kFixed>(c, a, b, p, m);
  scatter<kFixed>(c, bodies, a, b);
}

#define TACTUS_SWEEP(V, kBias, kFixed, kFriction, kTotals)                                                  \
  template void solve<kBias, kFixed, kFriction, kTotals, V>(ContactRow<V>&, const SolverBodies<LaneOf<V>>&, \
                                                            const SweepRule<LaneOf<V>>&, PointOrder) noexcept;
#define TACTUS_SWEEPS(V, kFixed)                                                                      \
  template void warm_start<kFixed, V>(const ContactRow<V>&, const SolverBodies<LaneOf<V>>&) noexcept; \
  TACTUS_SWEEP(V, true, kFixed, false, false)                                                         \
  TACTUS_SWEEP(V, true, kFixed, true, false)                                                          \
  TACTUS_SWEEP(V, false, kFixed, true, true)                                                          \
  TACTUS_SWEEP(V, false, kFixed, true, false)                                                         \
  TACTUS_SWEEP(V, false, kFixed, false, true)                                                         \
  TACTUS_SWEEP(V, false, kFixed, false, false)
#define TACTUS_INSTANTIATE(V)                                                                                 \
  template void fill_lane(ContactRow<V>&, int, std::uint32_t, const Contact&, const SolverBodies<LaneOf<V>>&, \
                          double) noexcept;                                                                   \
  template void complete<V>(ContactRow<V>&) noexcept;                                                         \
  TACTUS_SWEEPS(V, false)                                                                                     \
  TACTUS_SWEEPS(V, true)
TACTUS_INSTANTIATE(double)
TACTUS_INSTANTIATE(float)
TACTUS_INSTANTIATE(Register<double>)
TACTUS_INSTANTIATE(Register<float>)
#undef TACTUS_INSTANTIATE
#undef TACTUS_SWEEPS
#undef TACTUS_SWEEP

}  // namespace tactus::physics
