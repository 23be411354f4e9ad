#include "rt/physics/effects/gravity.h"

namespace tactus::physics {

void Gravity::fall(StageContext& c) noexcept {
  if (c.settings.gravity == Vec3d{}) return;
  const Vec3d change = c.h * c.settings.gravity;
  for_each_slot(c, [change, motion = c.motion, bodies = c.bodies](std::uint32_t i) noexcept {
    if (motion[i].inverse_mass > 0.0) motion[i].v += bodies[i].gravity_scale * change;
  });
}

}  // namespace tactus::physics
