#include "rt/physics/effects/restitution.h"

#include <algorithm>
#include <cmath>

#include "rt/physics/effects/contact_speed.h"

namespace tactus::physics {
namespace {

// A box that lands on a face bounces on four points at once: after these passes they have converged to a few per cent.
constexpr int kPasses = 8;

// The gap at the point after the bodies' motion since the start of the step [m]. On a round side it follows the motion
// of the ball's centre, not that of the point.
double gap_now(const StageContext& c, const Contact& contact, std::uint32_t point) noexcept {
  const auto shift = [&](std::uint32_t slot, const Vec3d& arm) noexcept {
    const SolverBody<double>& body = c.motion[slot];
    return dot(contact.normal, body.delta_position + rotate(body.delta_rotation, arm) - arm);
  };
  const ContactPoint& at = contact.points[point];
  double gap = at.separation - shift(contact.slot_a, at.from_a - contact.round_a * contact.normal);
  if (!contact.b_fixed) gap += shift(contact.slot_b, at.from_b + contact.round_b * contact.normal);
  return gap;
}

double mass_of(const StageContext& c, const Contact& contact, std::uint32_t point) noexcept {
  const auto inverse = [&](std::uint32_t slot, const Vec3d& arm) noexcept {
    return inverse_effective_mass(c.motion[slot].inverse_mass, c.inverse_inertia[slot], arm, contact.normal,
                                  contact.normal);
  };
  double sum = inverse(contact.slot_a, contact.points[point].from_a);
  if (!contact.b_fixed) sum += inverse(contact.slot_b, contact.points[point].from_b);
  return invert_or_zero(sum);
}

// Acceleration at which gravity moves the two bodies together [m/s^2].
double closing_gravity(const StageContext& c, const Contact& contact) noexcept {
  const auto fall = [&](std::uint32_t slot) noexcept {
    return c.motion[slot].inverse_mass > 0.0 ? c.bodies[slot].gravity_scale : 0.0;
  };
  return (fall(contact.slot_a) - (contact.b_fixed ? 0.0 : fall(contact.slot_b))) *
         dot(contact.normal, c.settings.gravity);
}

void push_apart(StageContext& c, const Contact& contact, std::uint32_t point, double impulse) noexcept {
  const Vec3d p = impulse * contact.normal;
  const ContactPoint& at = contact.points[point];
  apply_impulse_at(c.motion[contact.slot_a], c.inverse_inertia[contact.slot_a], at.from_a, -p);
  if (!contact.b_fixed) apply_impulse_at(c.motion[contact.slot_b], c.inverse_inertia[contact.slot_b], at.from_b, p);
}

}  // namespace

void Restitution::register_stages(StageTable& table) noexcept {
  table.add<&Restitution::list>(Phase::kPrepare, *this);
  table.add<&Restitution::bounce>(Phase::kForces, *this);
  table.add<&Restitution::finish>(Phase::kFinish, *this);
}

void Restitution::list(StageContext& c) noexcept {
  rows_.clear();
  groups_.clear();
  const Contact* last = nullptr;
  for (std::uint32_t k = 0; k < c.contacts.size(); ++k) {
    const Contact& contact = c.contacts[k];
    const BodyId b = contact.b_fixed ? c.fixed_bodies[contact.slot_b].id : c.bodies[contact.slot_b].id;
    const double coefficient = std::max(coefficient_of(c.bodies[contact.slot_a].id), coefficient_of(b));
    if (!(coefficient > 0.0) || !rows_.try_push({k, coefficient, {}})) continue;
    add_to_group(contact, last);
    last = &contact;
  }
}

// The row that was added last joins the rows of its two bodies, as long as their points fit.
void Restitution::add_to_group(const Contact& contact, const Contact* last) noexcept {
  std::uint32_t points = 0;
  for (std::uint32_t i = 0; i < contact.count; ++i) points += contact.points[i].redundant ? 0 : 1;
  const bool joins = last != nullptr && last->key.of_bodies() == contact.key.of_bodies() &&
                     groups_[groups_.size() - 1].points + points <= kMaxStrikes;
  if (!joins) (void)groups_.try_push({rows_.size() - 1, 0, 0});
  Group& group = groups_[groups_.size() - 1];
  ++group.count;
  group.points += points;
}

void Restitution::add_strikes(const StageContext& c, std::uint32_t row, Strikes& strikes) const noexcept {
  const Contact& contact = c.contacts[rows_[row].contact];
  for (std::uint32_t i = 0; i < contact.count; ++i) {
    if (contact.points[i].redundant) continue;
    const double speed = -separating_speed(c, contact, i);
    const double gap = gap_now(c, contact, i);
    if (!(speed > kMinSpeed && gap < 2.0 * speed * c.h)) continue;
    const double work = 2.0 * closing_gravity(c, contact) * std::max(0.0, gap);  // twice the work per kilogram
    const double square = rows_[row].coefficient * rows_[row].coefficient * (speed * speed + work) - work;
    (void)strikes.try_push({.row = row,
                            .point = i,
                            .speed = speed,
                            .after = std::sqrt(std::max(0.0, square)),
                            .mass = mass_of(c, contact, i),
                            .impulse = 0.0});
  }
}

bool Restitution::bounce_off(StageContext& c, const Group& group) noexcept {
  Strikes strikes;
  for (std::uint32_t k = 0; k < group.count; ++k) add_strikes(c, group.first + k, strikes);
  if (strikes.empty()) return false;
  const auto contact_of = [&](const Strike& strike) noexcept -> const Contact& {
    return c.contacts[rows_[strike.row].contact];
  };
  for (int pass = 0; pass < kPasses; ++pass)
    for (Strike& strike : strikes) {
      const Contact& contact = contact_of(strike);
      const double wanted = strike.impulse + strike.mass * (strike.after - separating_speed(c, contact, strike.point));
      const double next = std::max(0.0, wanted);
      push_apart(c, contact, strike.point, next - strike.impulse);
      strike.impulse = next;
    }
  // The bodies gain the energy impulse times mean separating speed, here (went - came) / 2.
  double came = 0.0, went = 0.0;
  for (const Strike& strike : strikes) {
    came += strike.impulse * strike.speed;
    went += strike.impulse * separating_speed(c, contact_of(strike), strike.point);
  }
  const double share = went > came ? 2.0 * came / (went + came) : 1.0;
  for (const Strike& strike : strikes) {
    if (share < 1.0) push_apart(c, contact_of(strike), strike.point, (share - 1.0) * strike.impulse);
    rows_[strike.row].given[strike.point] += share * strike.impulse;
  }
  return true;
}

void Restitution::bounce(StageContext& c) noexcept {
  bool struck = true;
  for (int round = 0; struck && round < kMaxRounds; ++round) {
    struck = false;
    const std::uint32_t count = groups_.size();
    for (std::uint32_t k = 0; k < count; ++k) struck |= bounce_off(c, groups_[round % 2 == 0 ? k : count - 1 - k]);
  }
}

void Restitution::finish(StageContext& c) noexcept {
  for (const Row& row : rows_) {
    Contact& contact = c.contacts[row.contact];
    for (std::uint32_t i = 0; i < contact.count; ++i) contact.points[i].total_normal_impulse += row.given[i];
  }
}

}  // namespace tactus::physics
