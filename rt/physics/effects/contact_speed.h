// The speed at which the bodies of a contact separate at one of its points, from the solver's present velocities.
// Thread: [rt]; pure. Frame: world. Units: SI.
#pragma once

#include "rt/physics/effects/stage.h"

namespace tactus::physics {

// m/s, along the contact's normal; negative while approaching.
inline double separating_speed(const StageContext& c, const Contact& contact, std::uint32_t point) noexcept {
  Vec3d v = -velocity_at(c.motion[contact.slot_a], contact.points[point].from_a);
  if (!contact.b_fixed) v += velocity_at(c.motion[contact.slot_b], contact.points[point].from_b);
  return dot(contact.normal, v);
}

}  // namespace tactus::physics
