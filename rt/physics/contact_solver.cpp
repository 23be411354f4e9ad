#include "rt/physics/contact_solver.h"

#include <algorithm>
#include <cmath>

namespace tactus::physics {
namespace {

// An impulse and its moment about the plane's centre, or a change of the relative motion there, by blocks.
template <class T>
struct NormalPart {
  T n{}, m1{}, m2{};
};
template <class T>
struct TangentPart {
  T t1{}, t2{}, mn{};
};

// How far the bodies' motion has changed the gap since the start of the step: gap + x slope_1 + y slope_2.
template <class T>
struct GapChange {
  T gap, slope_1, slope_2;
};

template <bool kFixed, class T>
[[gnu::always_inline]] inline GapChange<T> gap_change(const ContactConstraint<T>& c, const SolverBody<T>& a,
                                                      const SolverBody<T>& b) noexcept {
  // n . (R r - r) = (R^T n - n) . r: the normal is turned back once instead of every point forth.
  const Vec3<T> turn_a = rotate_inverse(a.delta_rotation, c.n) - c.n;
  T gap = -dot(c.n, a.delta_position) - dot(turn_a, c.c_a);
  Vec3<T> turn = -turn_a;
  if constexpr (!kFixed) {
    const Vec3<T> turn_b = rotate_inverse(b.delta_rotation, c.n) - c.n;
    gap += dot(c.n, b.delta_position) + dot(turn_b, c.c_b);
    turn += turn_b;
  }
  return {gap, dot(turn, c.t1), dot(turn, c.t2)};
}

// The normal rows, point after point. Returns what they added; `v` ends as the relative motion after it.
template <bool kBias, bool kTotals, class T>
[[gnu::always_inline]] inline NormalPart<T> solve_normals(ContactConstraint<T>& c, const GapChange<T>& moved,
                                                          NormalPart<T>& v, const SweepRule<T>& rule) noexcept {
  const SymBlock<T>& w = c.w_normal;
  NormalPart<T> sum;
  for (std::uint32_t i = 0; i < c.count; ++i) {
    const T x = c.x[i], y = c.y[i], last = c.normal_impulse[i];
    const T s = c.separation[i] + moved.gap + x * moved.slope_1 + y * moved.slope_2;
    T mass = c.normal_mass[i], keep = last;
    if (s > T(0)) {
      keep -= mass * (s * rule.inverse_h);  // may close the gap, no more
    } else if constexpr (kBias) {
      const Softness<T>& soft = rule.softness;
      const T push = std::max(soft.mass_scale * soft.bias_rate * std::min(T(0), s + rule.slop), -rule.max_push_speed);
      keep -= mass * push + soft.impulse_scale * last;
      mass *= soft.mass_scale;
    }
    // What a unit impulse here does: W (1, y, -x).
    const T by_n = w[0] + w[3] * y - w[4] * x, by_1 = w[3] + w[1] * y - w[5] * x, by_2 = w[4] + w[5] * y - w[2] * x;
    const T next = std::max(T(0), keep - mass * (v.n + (y * v.m1 - x * v.m2)));
    const T change = next - last;
    c.normal_impulse[i] = next;
    v.n += by_n * change, v.m1 += by_1 * change, v.m2 += by_2 * change;
    sum.n += change, sum.m1 += y * change, sum.m2 -= x * change;
    if constexpr (kTotals) c.total_normal_impulse[i] += next;
  }
  return sum;
}

// The friction rows, point after point, each within the disk of its own normal impulse.
template <bool kTotals, class T>
[[gnu::always_inline]] inline TangentPart<T> solve_friction(ContactConstraint<T>& c, TangentPart<T> v) noexcept {
  const SymBlock<T>& w = c.w_tangent;
  TangentPart<T> sum;
  for (std::uint32_t i = 0; i < c.count; ++i) {
    const T x = c.x[i], y = c.y[i], mass = c.tangent_mass[i];
    const T last_1 = c.tangent_impulse[0][i], last_2 = c.tangent_impulse[1][i];
    if (c.normal_impulse[i] == T(0) && last_1 == T(0) && last_2 == T(0)) continue;  // about to touch, not touching
    T next_1 = last_1 - mass * (v.t1 - y * v.mn), next_2 = last_2 - mass * (v.t2 + x * v.mn);
    clamp_to_disk(next_1, next_2, c.friction * c.normal_impulse[i]);
    const T f1 = next_1 - last_1, f2 = next_2 - last_2, m = x * f2 - y * f1;
    c.tangent_impulse[0][i] = next_1, c.tangent_impulse[1][i] = next_2;
    v.t1 += w[0] * f1 + w[3] * f2 + w[4] * m;
    v.t2 += w[3] * f1 + w[1] * f2 + w[5] * m;
    v.mn += w[4] * f1 + w[5] * f2 + w[2] * m;
    sum.t1 += f1, sum.t2 += f2, sum.mn += m;
    if constexpr (kTotals) c.total_tangent_impulse[0][i] += next_1, c.total_tangent_impulse[1][i] += next_2;
  }
  return sum;
}

// Cuts friction back to the disks of normal impulses that have just shrunk.
template <class T>
TangentPart<T> shrink_friction(ContactConstraint<T>& c) noexcept {
  TangentPart<T> sum;
  for (std::uint32_t i = 0; i < c.count; ++i) {
    T next_1 = c.tangent_impulse[0][i], next_2 = c.tangent_impulse[1][i];
    clamp_to_disk(next_1, next_2, c.friction * c.normal_impulse[i]);
    const T f1 = next_1 - c.tangent_impulse[0][i], f2 = next_2 - c.tangent_impulse[1][i];
    c.tangent_impulse[0][i] = next_1, c.tangent_impulse[1][i] = next_2;
    sum.t1 += f1, sum.t2 += f2, sum.mn += c.x[i] * f2 - c.y[i] * f1;
  }
  return sum;
}

template <class T>
bool lost_most_of_its_impulse(const ContactConstraint<T>& c, T change) noexcept {
  T left = T(0);
  for (std::uint32_t i = 0; i < c.count; ++i) left += c.normal_impulse[i];
  return -change > left;  // more went than is left
}

// The impulse `p` at the plane's centre and the moment `m` there: on B, the opposite on A.
template <bool kFixed, class T>
[[gnu::always_inline]] inline void apply_to_bodies(const ContactConstraint<T>& c, const SolverBodies<T>& bodies,
                                                   const Vec3<T>& p, const Vec3<T>& m) noexcept {
  SolverBody<T>& a = bodies.motion[c.a];
  a.v -= a.inverse_mass * p;
  a.w -= bodies.inverse_inertia[c.a] * (cross(c.c_a, p) + m);
  if constexpr (!kFixed) {
    SolverBody<T>& b = bodies.motion[c.b];
    b.v += b.inverse_mass * p;
    b.w += bodies.inverse_inertia[c.b] * (cross(c.c_b, p) + m);
  }
}

template <bool kBias, bool kFixed, bool kFriction, bool kTotals, class T>
void solve_contact(ContactConstraint<T>& c, const SolverBodies<T>& bodies, const SweepRule<T>& rule) noexcept {
  const SolverBody<T>& a = bodies.motion[c.a];
  const SolverBody<T>& b = bodies.motion[kFixed ? c.a : c.b];
  const GapChange<T> moved = gap_change<kFixed>(c, a, b);
  Vec3<T> v = -velocity_at(a, c.c_a), w = -a.w;
  if constexpr (!kFixed) v += velocity_at(b, c.c_b), w += b.w;

  NormalPart<T> normal_motion{dot(c.n, v), dot(c.t1, w), dot(c.t2, w)};
  const NormalPart<T> pressed = solve_normals<kBias, kTotals>(c, moved, normal_motion, rule);
  Vec3<T> p = pressed.n * c.n, m = pressed.m1 * c.t1 + pressed.m2 * c.t2;
  if constexpr (kFriction) {
    const std::array<T, 9>& k = c.w_cross;
    const TangentPart<T> rubbed =
        solve_friction<kTotals>(c, {dot(c.t1, v) + k[0] * pressed.n + k[1] * pressed.m1 + k[2] * pressed.m2,
                                    dot(c.t2, v) + k[3] * pressed.n + k[4] * pressed.m1 + k[5] * pressed.m2,
                                    dot(c.n, w) + k[6] * pressed.n + k[7] * pressed.m1 + k[8] * pressed.m2});
    p += rubbed.t1 * c.t1 + rubbed.t2 * c.t2;
    m += rubbed.mn * c.n;
  } else if (kBias && pressed.n < T(0) && lost_most_of_its_impulse(c, pressed.n)) {
    // The impulse of an impact was given again as warm start, and the friction that came with it must go as the normal
    // part goes: left to the relax sweep, the contacts solved before this one answer to it and keep the energy.
    const TangentPart<T> rubbed = shrink_friction(c);
    p += rubbed.t1 * c.t1 + rubbed.t2 * c.t2;
    m += rubbed.mn * c.n;
  }
  // Many contacts are only about to touch; leaving them out changes no bit.
  if (p == Vec3<T>{} && m == Vec3<T>{}) return;
  apply_to_bodies<kFixed>(c, bodies, p, m);
}

// W: the change of the relative motion at the plane's centre by a unit impulse or moment there.
template <class T>
void fill_mobility(ContactConstraint<T>& c, const SolverBodies<T>& bodies, bool b_fixed) noexcept {
  struct Answer {
    Vec3<T> v, w;
  };
  const auto answer_of = [&](const Vec3<T>& p, const Vec3<T>& m) noexcept {
    const Vec3<T> w_a = bodies.inverse_inertia[c.a] * (cross(c.c_a, p) + m);
    Answer out{bodies.motion[c.a].inverse_mass * p + cross(w_a, c.c_a), w_a};
    if (!b_fixed) {
      const Vec3<T> w_b = bodies.inverse_inertia[c.b] * (cross(c.c_b, p) + m);
      out.v += bodies.motion[c.b].inverse_mass * p + cross(w_b, c.c_b);
      out.w += w_b;
    }
    return out;
  };
  const Vec3<T> none;
  const Answer n = answer_of(c.n, none), m1 = answer_of(none, c.t1), m2 = answer_of(none, c.t2);
  const Answer t1 = answer_of(c.t1, none), t2 = answer_of(c.t2, none), mn = answer_of(none, c.n);
  c.w_normal = {dot(n.v, c.n), dot(m1.w, c.t1), dot(m2.w, c.t2), dot(m1.v, c.n), dot(m2.v, c.n), dot(m2.w, c.t1)};
  c.w_tangent = {dot(t1.v, c.t1), dot(t2.v, c.t2), dot(mn.w, c.n), dot(t2.v, c.t1), dot(mn.v, c.t1), dot(mn.v, c.t2)};
  c.w_cross = {dot(n.v, c.t1),  dot(m1.v, c.t1), dot(m2.v, c.t1), dot(n.v, c.t2), dot(m1.v, c.t2),
               dot(m2.v, c.t2), dot(n.w, c.n),   dot(m1.w, c.n),  dot(m2.w, c.n)};
}

template <class T>
void fill_point(ContactConstraint<T>& c, std::uint32_t i, const ContactPoint<T>& from) noexcept {
  const Vec3<T> from_centre = from.from_a - c.c_a;
  const T x = dot(from_centre, c.t1), y = dot(from_centre, c.t2);
  c.x[i] = x, c.y[i] = y;
  c.separation[i] = from.separation;
  const SymBlock<T>&w = c.w_normal, &k = c.w_tangent;
  c.normal_mass[i] = invert_or_zero(w[0] + y * y * w[1] + x * x * w[2] + T(2) * (y * w[3] - x * w[4] - x * y * w[5]));
  c.tangent_mass[i] = tangent_mass_of(k[0] - T(2) * y * k[4] + y * y * k[2], k[1] + T(2) * x * k[5] + x * x * k[2],
                                      k[3] + x * k[4] - y * k[5] - x * y * k[2]);
  c.normal_impulse[i] = from.normal_impulse;
  c.tangent_impulse[0][i] = from.tangent_impulse[0], c.tangent_impulse[1][i] = from.tangent_impulse[1];
  c.total_normal_impulse[i] = c.total_tangent_impulse[0][i] = c.total_tangent_impulse[1][i] = T(0);
}

}  // namespace

template <class T>
void ContactSolver<T>::prepare(std::span<const Contact<T>> contacts, SolverBodies<T> bodies) noexcept {
  constraints_.resize(static_cast<std::uint32_t>(contacts.size()));
  first_fixed_ = 0;
  for (std::uint32_t k = 0; k < constraints_.size(); ++k) {
    const Contact<T>& contact = contacts[k];
    ContactConstraint<T>& c = constraints_[k];
    if (!contact.b_fixed) first_fixed_ = k + 1;
    c.a = contact.slot_a, c.b = contact.slot_b, c.count = contact.count;
    c.friction = contact.friction;
    c.n = contact.normal;
    const auto [t1, t2] = tangents_of(c.n);
    c.t1 = t1, c.t2 = t2;
    c.c_a = c.c_b = {};
    for (std::uint32_t i = 0; i < c.count; ++i) c.c_a += contact.points[i].from_a, c.c_b += contact.points[i].from_b;
    c.c_a *= T(1) / static_cast<T>(c.count), c.c_b *= T(1) / static_cast<T>(c.count);
    fill_mobility(c, bodies, contact.b_fixed);
    for (std::uint32_t i = 0; i < c.count; ++i) fill_point(c, i, contact.points[i]);
  }
}

template <class T>
void ContactSolver<T>::warm_start(SolverBodies<T> bodies) const noexcept {
  for (std::uint32_t k = 0; k < constraints_.size(); ++k) {
    const ContactConstraint<T>& c = constraints_[k];
    NormalPart<T> pressed;
    TangentPart<T> rubbed;
    for (std::uint32_t i = 0; i < c.count; ++i) {
      const T x = c.x[i], y = c.y[i], f = c.normal_impulse[i], f1 = c.tangent_impulse[0][i],
              f2 = c.tangent_impulse[1][i];
      pressed.n += f, pressed.m1 += y * f, pressed.m2 -= x * f;
      rubbed.t1 += f1, rubbed.t2 += f2, rubbed.mn += x * f2 - y * f1;
    }
    const Vec3<T> p = pressed.n * c.n + rubbed.t1 * c.t1 + rubbed.t2 * c.t2;
    const Vec3<T> m = pressed.m1 * c.t1 + pressed.m2 * c.t2 + rubbed.mn * c.n;
    k < first_fixed_ ? apply_to_bodies<false>(c, bodies, p, m) : apply_to_bodies<true>(c, bodies, p, m);
  }
}

template <class T>
template <bool kBias, bool kFriction, bool kTotals>
void ContactSolver<T>::sweep(SolverBodies<T> bodies, const SweepRule<T>& rule) noexcept {
  for (std::uint32_t k = 0; k < first_fixed_; ++k)
    solve_contact<kBias, false, kFriction, kTotals>(constraints_[k], bodies, rule);
  for (std::uint32_t k = first_fixed_; k < constraints_.size(); ++k)
    solve_contact<kBias, true, kFriction, kTotals>(constraints_[k], bodies, rule);
}

template <class T>
void ContactSolver<T>::solve_biased(SolverBodies<T> bodies, const SweepRule<T>& rule) noexcept {
  sweep<true, false, false>(bodies, rule);
}

template <class T>
void ContactSolver<T>::relax(SolverBodies<T> bodies, const SweepRule<T>& rule, bool friction, bool last) noexcept {
  if (friction)
    last ? sweep<false, true, true>(bodies, rule) : sweep<false, true, false>(bodies, rule);
  else
    last ? sweep<false, false, true>(bodies, rule) : sweep<false, false, false>(bodies, rule);
}

template <class T>
void ContactSolver<T>::add_to_totals() noexcept {
  for (ContactConstraint<T>& c : constraints_)
    for (std::uint32_t i = 0; i < c.count; ++i) {
      c.total_normal_impulse[i] += c.normal_impulse[i];
      for (int d = 0; d < 2; ++d) c.total_tangent_impulse[d][i] += c.tangent_impulse[d][i];
    }
}

template <class T>
void ContactSolver<T>::scale_impulses(T factor) noexcept {
  for (ContactConstraint<T>& c : constraints_)
    for (std::uint32_t i = 0; i < c.count; ++i) {
      c.normal_impulse[i] *= factor;
      for (int d = 0; d < 2; ++d) c.tangent_impulse[d][i] *= factor;
    }
}

template <class T>
void ContactSolver<T>::store_impulses(std::span<Contact<T>> contacts, T share) const noexcept {
  for (std::uint32_t k = 0; k < constraints_.size(); ++k) {
    const ContactConstraint<T>& c = constraints_[k];
    for (std::uint32_t i = 0; i < c.count; ++i) {
      ContactPoint<T>& to = contacts[k].points[i];
      const auto blend = [share](T& kept, T now) noexcept { kept = share == T(1) ? now : kept + share * (now - kept); };
      blend(to.normal_impulse, c.normal_impulse[i]);
      for (int d = 0; d < 2; ++d) blend(to.tangent_impulse[d], c.tangent_impulse[d][i]);
    }
  }
}

template <class T>
void ContactSolver<T>::store(std::span<Contact<T>> contacts, T share) const noexcept {
  store_impulses(contacts, share);
  for (std::uint32_t k = 0; k < constraints_.size(); ++k) {
    const ContactConstraint<T>& c = constraints_[k];
    for (std::uint32_t i = 0; i < c.count; ++i) {
      ContactPoint<T>& to = contacts[k].points[i];
      to.total_normal_impulse = c.total_normal_impulse[i];
      to.total_friction = c.total_tangent_impulse[0][i] * c.t1 + c.total_tangent_impulse[1][i] * c.t2;
    }
  }
}

template class ContactSolver<double>;
template class ContactSolver<float>;

}  // namespace tactus::physics
