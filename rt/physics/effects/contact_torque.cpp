#include "rt/physics/effects/contact_torque.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace tactus::physics {
namespace {

// The line through the points of a contact: its unit direction in the contact's plane; empty if a point is more than
// `beside` [m] off it.
std::optional<Vec3d> line_of(const Contact& contact, double beside) noexcept {
  Vec3d along;
  for (std::uint32_t i = 1; i < contact.count; ++i) {
    const Vec3d way = contact.points[i].from_a - contact.points[0].from_a;
    if (norm_squared(way) > norm_squared(along)) along = way;
  }
  along -= dot(along, contact.normal) * contact.normal;
  const double length = norm(along);
  if (!(length > beside)) return std::nullopt;
  along = along * (1.0 / length);
  const Vec3d across = cross(contact.normal, along);
  for (std::uint32_t i = 1; i < contact.count; ++i)
    if (!(std::abs(dot(across, contact.points[i].from_a - contact.points[0].from_a)) <= beside)) return std::nullopt;
  return along;
}

}  // namespace

void ContactTorque::register_stages(StageTable& table) noexcept {
  table.add<&ContactTorque::list>(Phase::kPrepare, *this);
  table.add<&ContactTorque::begin_sub_step>(Phase::kBeginSubStep, *this);
  table.add<&ContactTorque::resist>(Phase::kBiased, *this);
  table.add<&ContactTorque::resist>(Phase::kRelax, *this);
}

void ContactTorque::list(StageContext& c) noexcept {
  rows_.clear();
  for (std::uint32_t k = 0; k < c.contacts.size(); ++k) {
    const Contact& contact = c.contacts[k];
    const ContactPatch a = patch_of(c.bodies[contact.slot_a].id);
    const ContactPatch b = patch_of(contact.b_fixed ? c.fixed_bodies[contact.slot_b].id : c.bodies[contact.slot_b].id);
    const double radius = std::max(a.radius_m, b.radius_m), rolling = std::max(a.rolling_m, b.rolling_m);
    double pressed = 0.0;
    for (std::uint32_t i = 0; i < contact.count; ++i) pressed += contact.points[i].normal_impulse;
    if ((radius == 0.0 && rolling == 0.0) || pressed == 0.0) continue;
    SymMat3d inverse_inertia = c.inverse_inertia[contact.slot_a];
    if (!contact.b_fixed) inverse_inertia = inverse_inertia + c.inverse_inertia[contact.slot_b];
    Row row;
    row.contact = k;
    if (contact.count > 1) {
      const auto line = line_of(contact, rolling);
      if (!line) continue;
      row.t1 = *line;
      row.roll_mass = invert_or_zero(dot(inverse_inertia * row.t1, row.t1));
      row.most_roll = rolling * pressed;
      (void)rows_.try_push(row);
      continue;
    }
    const auto [t1, t2] = tangents_of(contact.normal);
    row.t1 = t1;
    row.t2 = t2;
    row.spin_mass = invert_or_zero(dot(inverse_inertia * contact.normal, contact.normal));
    row.roll_mass =
        tangent_mass_of(dot(inverse_inertia * t1, t1), dot(inverse_inertia * t2, t2), dot(inverse_inertia * t1, t2));
    row.most_spin = c.settings.friction ? (2.0 / 3) * contact.friction * radius * pressed : 0.0;
    row.most_roll = rolling * pressed;
    (void)rows_.try_push(row);
  }
}

void ContactTorque::begin_sub_step(StageContext&) noexcept {
  for (Row& row : rows_) row.spin = row.roll_1 = row.roll_2 = 0.0;
}

void ContactTorque::resist(StageContext& c) noexcept {
  for (Row& row : rows_) {
    const Contact& contact = c.contacts[row.contact];
    SolverBody<double>& a = c.motion[contact.slot_a];
    Vec3d w = -a.w;
    if (!contact.b_fixed) w += c.motion[contact.slot_b].w;
    const double spin = std::clamp(row.spin - row.spin_mass * dot(contact.normal, w), -row.most_spin, row.most_spin);
    double roll_1 = row.roll_1 - row.roll_mass * dot(row.t1, w), roll_2 = row.roll_2 - row.roll_mass * dot(row.t2, w);
    clamp_to_disk(roll_1, roll_2, row.most_roll);
    const Vec3d m =
        (spin - row.spin) * contact.normal + (roll_1 - row.roll_1) * row.t1 + (roll_2 - row.roll_2) * row.t2;
    row.spin = spin;
    row.roll_1 = roll_1;
    row.roll_2 = roll_2;
    a.w -= c.inverse_inertia[contact.slot_a] * m;
    if (!contact.b_fixed) c.motion[contact.slot_b].w += c.inverse_inertia[contact.slot_b] * m;
  }
}

}  // namespace tactus::physics
