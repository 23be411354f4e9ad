#include "rt/physics/effects/restitution.h"

#include <algorithm>

namespace tactus::physics {
namespace {

// A box that lands on a face bounces on four points at once: after these passes they agree to a few per cent.
constexpr int kPasses = 8;

}  // namespace

template <class T>
void Restitution<T>::enter(StageTable<T>& table) noexcept {
  table.template add<&Restitution::list>(Phase::kPrepare, *this);
  table.template add<&Restitution::note_approach>(Phase::kForces, *this);
  table.template add<&Restitution::bounce>(Phase::kFinish, *this);
}

template <class T>
T Restitution<T>::separating_speed(const StageContext<T>& c, const Row& row) noexcept {
  const Contact<T>& contact = c.contacts[row.contact];
  Vec3<T> v = -velocity_at(c.motion[contact.slot_a], row.r_a);
  if (!contact.b_fixed) v += velocity_at(c.motion[contact.slot_b], row.r_b);
  return dot(contact.normal, v);
}

template <class T>
void Restitution<T>::list(StageContext<T>& c) noexcept {
  rows_.clear();
  for (std::uint32_t k = 0; k < c.contacts.size(); ++k) {
    const Contact<T>& contact = c.contacts[k];
    const BodyId b = contact.b_fixed ? c.fixed_bodies[contact.slot_b].id : c.bodies[contact.slot_b].id;
    const T coefficient = std::max(coefficient_of(c.bodies[contact.slot_a].id), coefficient_of(b));
    if (coefficient == T(0)) continue;
    for (std::uint32_t i = 0; i < contact.count; ++i) {
      const ContactPoint<T>& point = contact.points[i];
      T inverse = inverse_effective_mass(c.motion[contact.slot_a].inverse_mass, c.inverse_inertia[contact.slot_a],
                                         point.from_a, contact.normal, contact.normal);
      if (!contact.b_fixed)
        inverse += inverse_effective_mass(c.motion[contact.slot_b].inverse_mass, c.inverse_inertia[contact.slot_b],
                                          point.from_b, contact.normal, contact.normal);
      if (inverse > T(0)) (void)rows_.try_push({k, i, point.from_a, point.from_b, T(1) / inverse, coefficient});
    }
  }
}

template <class T>
void Restitution<T>::note_approach(StageContext<T>& c) noexcept {
  for (Row& row : rows_) row.approach = std::max(row.approach, -separating_speed(c, row));
}

template <class T>
void Restitution<T>::bounce(StageContext<T>& c) noexcept {
  std::uint32_t hits = 0;
  for (const Row& row : rows_)
    if (row.approach > kLeastSpeed && c.contacts[row.contact].points[row.point].total_normal_impulse > T(0))
      rows_[hits++] = row;
  rows_.resize(hits);
  for (int pass = 0; hits > 0 && pass < kPasses; ++pass) {
    for (Row& row : rows_) {
      const Contact<T>& contact = c.contacts[row.contact];
      const T wanted = row.impulse + row.mass * (row.coefficient * row.approach - separating_speed(c, row));
      const T next = std::max(T(0), wanted);
      const Vec3<T> p = (next - row.impulse) * contact.normal;
      row.impulse = next;
      apply_impulse_at(c.motion[contact.slot_a], c.inverse_inertia[contact.slot_a], row.r_a, -p);
      if (!contact.b_fixed) apply_impulse_at(c.motion[contact.slot_b], c.inverse_inertia[contact.slot_b], row.r_b, p);
    }
  }
  for (const Row& row : rows_) {
    ContactPoint<T>& point = c.contacts[row.contact].points[row.point];
    if (row.impulse == T(0)) continue;
    point.total_normal_impulse += row.impulse;
    point.normal_impulse = point.tangent_impulse[0] = point.tangent_impulse[1] = T(0);  // it goes apart
  }
}

template class Restitution<double>;
template class Restitution<float>;

}  // namespace tactus::physics
