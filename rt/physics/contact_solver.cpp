#include "rt/physics/contact_solver.h"

#include <algorithm>
#include <cmath>

namespace tactus::physics {
namespace {

// One contact in one sweep. The velocities of its two bodies stay in registers from the first row to the last.
template <bool kBias, bool kFixed, bool kFriction, bool kTotals, class T>
void solve_contact(ContactConstraint<T>& c, const SolverBodies<T>& bodies, const SweepRule<T>& rule) noexcept {
  SolverBody<T>& a = bodies.motion[c.a];
  SolverBody<T>& b = bodies.motion[kFixed ? c.a : c.b];
  const SymMat3<T>& inertia_a = bodies.inverse_inertia[c.a];
  const SymMat3<T>& inertia_b = bodies.inverse_inertia[kFixed ? c.a : c.b];
  const T mass_a = a.inverse_mass, mass_b = b.inverse_mass;
  Vec3<T> v_a = a.v, w_a = a.w, v_b, w_b;
  if constexpr (!kFixed) v_b = b.v, w_b = b.w;
  const Vec3<T> n = c.n;

  // n . R r = (R^T n) . r: the normal is turned back once instead of every anchor forth.
  const Vec3<T> n_a = rotate_inverse(a.delta_rotation, n);
  Vec3<T> n_b;
  T approach = -dot(n, a.delta_position);
  if constexpr (!kFixed) {
    n_b = rotate_inverse(b.delta_rotation, n);
    approach += dot(n, b.delta_position);
  }

  for (std::uint32_t i = 0; i < c.count; ++i) {
    ConstraintPoint<T>& p = c.points[i];
    T s = p.separation + approach - dot(n_a, p.r_a);
    if constexpr (!kFixed) s += dot(n_b, p.r_b);
    T bias = T(0), mass = p.normal_mass, keep = p.normal_impulse;
    if (s > T(0)) {
      bias = s * rule.inverse_h * mass;  // may close the gap, no more
    } else if constexpr (kBias) {
      const Softness<T>& soft = rule.softness;
      bias = std::max(soft.mass_scale * soft.bias_rate * std::min(T(0), s + rule.slop), -rule.max_push_speed) * mass;
      mass *= soft.mass_scale;
      keep -= soft.impulse_scale * keep;
    }
    const Vec3<T> x_a = cross(p.r_a, n);
    T u = -dot(n, v_a) - dot(x_a, w_a);
    Vec3<T> x_b;
    if constexpr (!kFixed) {
      x_b = cross(p.r_b, n);
      u += dot(n, v_b) + dot(x_b, w_b);
    }
    const T next = std::max(T(0), (keep - bias) - mass * u);
    const T change = next - p.normal_impulse;
    p.normal_impulse = next;
    v_a -= (change * mass_a) * n;
    w_a -= change * (inertia_a * x_a);
    if constexpr (!kFixed) {
      v_b += (change * mass_b) * n;
      w_b += change * (inertia_b * x_b);
    }
    if constexpr (kTotals) p.total_normal_impulse += next;
  }

  if constexpr (kFriction) {
    for (std::uint32_t i = 0; i < c.count; ++i) {
      ConstraintPoint<T>& p = c.points[i];
      Vec3<T> u = -v_a - cross(w_a, p.r_a);
      if constexpr (!kFixed) u += v_b + cross(w_b, p.r_b);
      T l1 = p.tangent_impulse[0] - p.tangent_mass * dot(c.t1, u);
      T l2 = p.tangent_impulse[1] - p.tangent_mass * dot(c.t2, u);
      clamp_to_disk(l1, l2, c.friction * p.normal_impulse);
      const Vec3<T> change = (l1 - p.tangent_impulse[0]) * c.t1 + (l2 - p.tangent_impulse[1]) * c.t2;
      p.tangent_impulse[0] = l1, p.tangent_impulse[1] = l2;
      v_a -= mass_a * change;
      w_a -= inertia_a * cross(p.r_a, change);
      if constexpr (!kFixed) {
        v_b += mass_b * change;
        w_b += inertia_b * cross(p.r_b, change);
      }
      if constexpr (kTotals) p.total_tangent_impulse[0] += l1, p.total_tangent_impulse[1] += l2;
    }
  }
  a.v = v_a, a.w = w_a;
  if constexpr (!kFixed) b.v = v_b, b.w = w_b;
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
    const T mass_a = bodies.motion[c.a].inverse_mass, mass_b = contact.b_fixed ? T(0) : bodies.motion[c.b].inverse_mass;
    const SymMat3<T> inertia_a = bodies.inverse_inertia[c.a];
    const SymMat3<T> inertia_b = contact.b_fixed ? SymMat3<T>{} : bodies.inverse_inertia[c.b];
    for (std::uint32_t i = 0; i < c.count; ++i) {
      const ContactPoint<T>& from = contact.points[i];
      ConstraintPoint<T>& p = c.points[i];
      p = {};
      p.r_a = from.from_a, p.r_b = from.from_b;
      p.separation = from.separation + dot(c.n, p.r_a) - (contact.b_fixed ? T(0) : dot(c.n, p.r_b));
      const auto k_of = [&](const Vec3<T>& d1, const Vec3<T>& d2) {
        return inverse_effective_mass(mass_a, inertia_a, p.r_a, d1, d2) +
               inverse_effective_mass(mass_b, inertia_b, p.r_b, d1, d2);
      };
      p.normal_mass = invert_or_zero(k_of(c.n, c.n));
      p.tangent_mass = tangent_mass_of(k_of(t1, t1), k_of(t2, t2), k_of(t1, t2));
      p.normal_impulse = from.normal_impulse;
      p.tangent_impulse[0] = from.tangent_impulse[0], p.tangent_impulse[1] = from.tangent_impulse[1];
    }
  }
}

template <class T>
void ContactSolver<T>::warm_start(SolverBodies<T> bodies) const noexcept {
  for (std::uint32_t k = 0; k < constraints_.size(); ++k) {
    const ContactConstraint<T>& c = constraints_[k];
    Vec3<T> sum, turn_a, turn_b;
    for (std::uint32_t i = 0; i < c.count; ++i) {
      const ConstraintPoint<T>& p = c.points[i];
      const Vec3<T> impulse = p.normal_impulse * c.n + p.tangent_impulse[0] * c.t1 + p.tangent_impulse[1] * c.t2;
      sum += impulse;
      turn_a += cross(p.r_a, impulse);
      turn_b += cross(p.r_b, impulse);
    }
    SolverBody<T>& a = bodies.motion[c.a];
    a.v -= a.inverse_mass * sum;
    a.w -= bodies.inverse_inertia[c.a] * turn_a;
    if (k >= first_fixed_) continue;
    SolverBody<T>& b = bodies.motion[c.b];
    b.v += b.inverse_mass * sum;
    b.w += bodies.inverse_inertia[c.b] * turn_b;
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
      ConstraintPoint<T>& p = c.points[i];
      p.total_normal_impulse += p.normal_impulse;
      p.total_tangent_impulse[0] += p.tangent_impulse[0], p.total_tangent_impulse[1] += p.tangent_impulse[1];
    }
}

template <class T>
void ContactSolver<T>::scale_impulses(T factor) noexcept {
  for (ContactConstraint<T>& c : constraints_)
    for (std::uint32_t i = 0; i < c.count; ++i) {
      ConstraintPoint<T>& p = c.points[i];
      p.normal_impulse *= factor, p.tangent_impulse[0] *= factor, p.tangent_impulse[1] *= factor;
    }
}

template <class T>
void ContactSolver<T>::store(std::span<Contact<T>> contacts) const noexcept {
  for (std::uint32_t k = 0; k < constraints_.size(); ++k) {
    const ContactConstraint<T>& c = constraints_[k];
    for (std::uint32_t i = 0; i < c.count; ++i) {
      const ConstraintPoint<T>& p = c.points[i];
      ContactPoint<T>& to = contacts[k].points[i];
      to.normal_impulse = p.normal_impulse;
      to.tangent_impulse[0] = p.tangent_impulse[0], to.tangent_impulse[1] = p.tangent_impulse[1];
      to.total_normal_impulse = p.total_normal_impulse;
      to.total_friction = p.total_tangent_impulse[0] * c.t1 + p.total_tangent_impulse[1] * c.t2;
    }
  }
}

template class ContactSolver<double>;
template class ContactSolver<float>;

}  // namespace tactus::physics
