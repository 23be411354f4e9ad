#include "rt/physics/effects/damping.h"

namespace tactus::physics {

template <class T>
void Damping<T>::slow_down(StageContext<T>& c) noexcept {
  const T linear = T(1) / (T(1) + c.h * setup_.linear_per_s), angular = T(1) / (T(1) + c.h * setup_.angular_per_s);
  for_each_slot(c, [&](std::uint32_t i) noexcept {
    if (c.motion[i].inverse_mass == T(0)) return;
    c.motion[i].v *= linear;
    c.motion[i].w *= angular;
  });
}

template class Damping<double>;
template class Damping<float>;

}  // namespace tactus::physics
