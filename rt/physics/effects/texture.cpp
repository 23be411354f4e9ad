#include "rt/physics/effects/texture.h"

#include <algorithm>
#include <numbers>

namespace tactus::physics {
namespace {

// -grad h of the grain at `at`, in the body's frame.
template <class T>
Vec3<T> downhill(const Grain<T>& grain, const Vec3<T>& at) noexcept {
  const T k = T(2) * std::numbers::pi_v<T> / grain.wavelength_m;
  return -grain.height_m * k * Vec3<T>{sin_cos(k * at.x).cos, sin_cos(k * at.y).cos, sin_cos(k * at.z).cos};
}

}  // namespace

template <class T>
void Texture<T>::feel(StageContext<T>& c) noexcept {
  for (const Contact<T>& contact : c.contacts) {
    const Body<T>& a = c.bodies[contact.slot_a];
    const Body<T>& b = contact.b_fixed ? c.fixed_bodies[contact.slot_b] : c.bodies[contact.slot_b];
    const bool proxy_is_a = a.id == setup_.proxy;
    if (!proxy_is_a && b.id != setup_.proxy) continue;
    const Body<T>& other = proxy_is_a ? b : a;
    if (other.id >= setup_.by_id.size() || setup_.by_id[other.id].height_m == T(0)) continue;
    const Grain<T>& grain = setup_.by_id[other.id];

    // Bodies are as the step began; what they did since is in the solver's.
    static constexpr SolverBody<T> still{};
    const SolverBody<T>& proxy_now = c.motion[proxy_is_a ? contact.slot_a : contact.slot_b];
    const SolverBody<T>& other_now =
        proxy_is_a ? (contact.b_fixed ? still : c.motion[contact.slot_b]) : c.motion[contact.slot_a];
    const Body<T>& proxy = proxy_is_a ? a : b;
    const Vec3<T> offset = (proxy.motion.pose.position - other.motion.pose.position) +
                           (proxy_now.delta_position - other_now.delta_position);
    const Quat<T> rotation = other_now.delta_rotation * other.motion.pose.rotation;
    for (std::uint32_t i = 0; i < contact.count; ++i) {
      const ContactPoint<T>& point = contact.points[i];
      const Vec3<T>& arm = proxy_is_a ? point.from_a : point.from_b;
      const Vec3<T>& n = contact.normal;
      Vec3<T> slip = velocity_at(proxy_now, arm) - velocity_at(other_now, offset + arm);
      slip -= dot(n, slip) * n;
      const T beats = norm(slip) * c.settings.dt / grain.wavelength_m;  // waves in a step
      const T share = std::clamp(T(2) - T(4) * beats, T(0), T(1));
      const T pressed = point.total_normal_impulse / c.settings.dt;
      if (share * pressed == T(0)) continue;
      Vec3<T> force = (share * pressed) * rotate(rotation, downhill(grain, rotate_inverse(rotation, offset + arm)));
      force -= dot(n, force) * n;
      c.report.felt.force += force, c.report.felt.torque += cross(arm, force);
    }
  }
}

template class Texture<double>;
template class Texture<float>;

}  // namespace tactus::physics
