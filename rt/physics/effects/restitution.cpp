#include "rt/physics/effects/restitution.h"

#include <algorithm>
#include <cmath>

#include "rt/physics/effects/contact_speed.h"

namespace tactus::physics {
namespace {

// A box that lands on a face bounces on four points at once: after these passes they agree to a few per cent.
constexpr int kPasses = 8;

// Where the bodies have taken the point since the start of the step.
template <class T>
T gap_now(const StageContext<T>& c, const Contact<T>& contact, std::uint32_t point) noexcept {
  const auto shift = [&](std::uint32_t slot, const Vec3<T>& arm) noexcept {
    const SolverBody<T>& body = c.motion[slot];
    return dot(contact.normal, body.delta_position + rotate(body.delta_rotation, arm) - arm);
  };
  T gap = contact.points[point].separation - shift(contact.slot_a, contact.points[point].from_a);
  if (!contact.b_fixed) gap += shift(contact.slot_b, contact.points[point].from_b);
  return gap;
}

template <class T>
T mass_of(const StageContext<T>& c, const Contact<T>& contact, std::uint32_t point) noexcept {
  const auto inverse = [&](std::uint32_t slot, const Vec3<T>& arm) noexcept {
    return inverse_effective_mass(c.motion[slot].inverse_mass, c.inverse_inertia[slot], arm, contact.normal,
                                  contact.normal);
  };
  T sum = inverse(contact.slot_a, contact.points[point].from_a);
  if (!contact.b_fixed) sum += inverse(contact.slot_b, contact.points[point].from_b);
  return invert_or_zero(sum);
}

// m/s^2, at which gravity brings the two bodies together.
template <class T>
T closing_gravity(const StageContext<T>& c, const Contact<T>& contact) noexcept {
  const auto fall = [&](std::uint32_t slot) noexcept {
    return c.motion[slot].inverse_mass > T(0) ? c.bodies[slot].gravity_scale : T(0);
  };
  return (fall(contact.slot_a) - (contact.b_fixed ? T(0) : fall(contact.slot_b))) *
         dot(contact.normal, c.settings.gravity);
}

template <class T>
void push_apart(StageContext<T>& c, const Contact<T>& contact, std::uint32_t point, T impulse) noexcept {
  const Vec3<T> p = impulse * contact.normal;
  const ContactPoint<T>& at = contact.points[point];
  apply_impulse_at(c.motion[contact.slot_a], c.inverse_inertia[contact.slot_a], at.from_a, -p);
  if (!contact.b_fixed) apply_impulse_at(c.motion[contact.slot_b], c.inverse_inertia[contact.slot_b], at.from_b, p);
}

}  // namespace

template <class T>
void Restitution<T>::enter(StageTable<T>& table) noexcept {
  table.template add<&Restitution::list>(Phase::kPrepare, *this);
  table.template add<&Restitution::bounce>(Phase::kForces, *this);
  table.template add<&Restitution::finish>(Phase::kFinish, *this);
}

template <class T>
void Restitution<T>::list(StageContext<T>& c) noexcept {
  rows_.clear();
  for (std::uint32_t k = 0; k < c.contacts.size(); ++k) {
    const Contact<T>& contact = c.contacts[k];
    const BodyId b = contact.b_fixed ? c.fixed_bodies[contact.slot_b].id : c.bodies[contact.slot_b].id;
    const T coefficient = std::max(coefficient_of(c.bodies[contact.slot_a].id), coefficient_of(b));
    if (coefficient > T(0)) (void)rows_.try_push({k, coefficient, {}});
  }
}

template <class T>
bool Restitution<T>::bounce_off(StageContext<T>& c, Row& row) noexcept {
  const Contact<T>& contact = c.contacts[row.contact];
  Strikes strikes;
  for (std::uint32_t i = 0; i < contact.count; ++i) {
    const T speed = -separating_speed(c, contact, i);
    const T gap = gap_now(c, contact, i);
    if (!(speed > kLeastSpeed && gap < T(2) * speed * c.h)) continue;
    const T work = T(2) * closing_gravity(c, contact) * std::max(T(0), gap);  // twice, a kilogram
    const T square = row.coefficient * row.coefficient * (speed * speed + work) - work;
    (void)strikes.try_push({i, speed, std::sqrt(std::max(T(0), square)), mass_of(c, contact, i), T(0)});
  }
  if (strikes.empty()) return false;
  for (int pass = 0; pass < kPasses; ++pass)
    for (Strike& strike : strikes) {
      const T wanted = strike.impulse + strike.mass * (strike.after - separating_speed(c, contact, strike.point));
      const T next = std::max(T(0), wanted);
      push_apart(c, contact, strike.point, next - strike.impulse);
      strike.impulse = next;
    }
  // Impulse times mean speed is what the bodies gain.
  T came = T(0), went = T(0);
  for (const Strike& strike : strikes)
    came += strike.impulse * strike.speed, went += strike.impulse * separating_speed(c, contact, strike.point);
  const T share = went > came ? T(2) * came / (went + came) : T(1);
  for (const Strike& strike : strikes) {
    if (share < T(1)) push_apart(c, contact, strike.point, (share - T(1)) * strike.impulse);
    row.given[strike.point] += share * strike.impulse;
  }
  return true;
}

template <class T>
void Restitution<T>::bounce(StageContext<T>& c) noexcept {
  bool struck = true;
  for (int round = 0; struck && round < kMostRounds; ++round) {
    struck = false;
    const std::uint32_t count = rows_.size();
    for (std::uint32_t k = 0; k < count; ++k) struck |= bounce_off(c, rows_[round % 2 == 0 ? k : count - 1 - k]);
  }
}

template <class T>
void Restitution<T>::finish(StageContext<T>& c) noexcept {
  for (const Row& row : rows_) {
    Contact<T>& contact = c.contacts[row.contact];
    for (std::uint32_t i = 0; i < contact.count; ++i) contact.points[i].total_normal_impulse += row.given[i];
  }
}

template class Restitution<double>;
template class Restitution<float>;

}  // namespace tactus::physics
