#include "rt/physics/effects/damping.h"

namespace tactus::physics {

void Damping::slow_down(StageContext& c) noexcept {
  const double linear = 1.0 / (1.0 + c.h * setup_.linear_per_s), angular = 1.0 / (1.0 + c.h * setup_.angular_per_s);
  for_each_slot(c, [&](std::uint32_t i) noexcept {
    if (c.motion[i].inverse_mass == 0.0) return;
    c.motion[i].v *= linear;
    c.motion[i].w *= angular;
  });
}

}  // namespace tactus::physics
