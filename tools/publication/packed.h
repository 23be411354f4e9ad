// Poses and contact forces as the shared memory and the viewer have them (layout.h).
//
// Thread: [any]; add_points allocates beyond the capacity of its list. Frame: world. Units: SI.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "rt/physics/world.h"
#include "tools/publication/layout.h"

namespace tactus::publication {

inline Position position_of(const Vec3d& p) noexcept {
  return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
}

inline Rotation rotation_of(const Quatd& q) noexcept {
  const auto packed = [](double component) noexcept {
    return static_cast<std::int16_t>(std::nearbyint(32767.0 * std::clamp(component, -1.0, 1.0)));
  };
  return {packed(q.w), packed(q.x), packed(q.y), packed(q.z)};
}

inline Quatd rotation_of(const Rotation& packed) noexcept {
  return normalized(Quatd{static_cast<double>(packed.w), static_cast<double>(packed.x), static_cast<double>(packed.y),
                          static_cast<double>(packed.z)});
}

inline Posed pose_of(const Position& p, const Rotation& packed) noexcept {
  return {{static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)}, rotation_of(packed)};
}

// Id of the contact's second body, which may be fixed.
inline BodyId second_of(const physics::Contact& contact, const physics::World& world) noexcept {
  return contact.b_fixed ? world.fixed_bodies()[contact.slot_b].id : world.bodies()[contact.slot_b].id;
}

// Force of a contact's point on body b; `per_s`: 1 / the time over which the impulses are summed.
inline ContactForce force_at(const physics::Contact& contact, std::uint32_t point, const physics::World& world,
                             double per_s) noexcept {
  const physics::Body& a = world.bodies()[contact.slot_a];
  const physics::ContactPoint& at = contact.points[point];
  const Position f = position_of(per_s * (at.total_normal_impulse * contact.normal + at.total_friction));
  return {.point = position_of(a.motion.pose.position + at.from_a),
          .x = f.x,
          .y = f.y,
          .z = f.z,
          .a = a.id,
          .b = second_of(contact, world)};
}

}  // namespace tactus::publication
