#include "rt/physics/effects/drag.h"

namespace tactus::physics {

void Drag::resist(StageContext& c) noexcept {
  for_each_slot(c, [&](std::uint32_t i) noexcept {
    const BodyId id = c.bodies[i].id;
    if (c.motion[i].inverse_mass == 0.0 || id >= setup_.per_m.size()) return;
    const Vec3d through = c.motion[i].v - setup_.flow;
    c.motion[i].v = setup_.flow + (1.0 / (1.0 + setup_.per_m[id] * norm(through) * c.h)) * through;
  });
}

}  // namespace tactus::physics
