#include "rt/physics/effects/drag.h"

namespace tactus::physics {

template <class T>
void Drag<T>::resist(StageContext<T>& c) noexcept {
  for_each_slot(c, [&](std::uint32_t i) noexcept {
    const BodyId id = c.bodies[i].id;
    if (c.motion[i].inverse_mass == T(0) || id >= setup_.per_m.size()) return;
    const Vec3<T> through = c.motion[i].v - setup_.flow;
    c.motion[i].v = setup_.flow + (T(1) / (T(1) + setup_.per_m[id] * norm(through) * c.h)) * through;
  });
}

template class Drag<double>;
template class Drag<float>;

}  // namespace tactus::physics
