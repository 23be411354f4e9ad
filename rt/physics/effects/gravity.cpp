#include "rt/physics/effects/gravity.h"

namespace tactus::physics {

template <class T>
void Gravity<T>::fall(StageContext<T>& c) noexcept {
  if (c.settings.gravity == Vec3<T>{}) return;
  const Vec3<T> change = c.h * c.settings.gravity;
  for_each_slot(c, [change, motion = c.motion, bodies = c.bodies](std::uint32_t i) noexcept {
    if (motion[i].inverse_mass > T(0)) motion[i].v += bodies[i].gravity_scale * change;
  });
}

template class Gravity<double>;
template class Gravity<float>;

}  // namespace tactus::physics
