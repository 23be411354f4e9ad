#include "rt/physics/effects/texture.h"

#include <algorithm>
#include <numbers>

namespace tactus::physics {
namespace {

// Returns -grad h of the texture at `at`, in the body's frame.
Vec3d downhill(const Grain& grain, const Vec3d& at) noexcept {
  const double k = 2.0 * std::numbers::pi / grain.wavelength_m;
  return -grain.height_m * k * Vec3d{sin_cos(k * at.x).cos, sin_cos(k * at.y).cos, sin_cos(k * at.z).cos};
}

}  // namespace

void Texture::feel(StageContext& c) noexcept {
  for (const Contact& contact : c.contacts) {
    const Body& a = c.bodies[contact.slot_a];
    const Body& b = contact.b_fixed ? c.fixed_bodies[contact.slot_b] : c.bodies[contact.slot_b];
    const bool proxy_is_a = a.id == setup_.proxy;
    if (!proxy_is_a && b.id != setup_.proxy) continue;
    const Body& other = proxy_is_a ? b : a;
    if (other.id >= setup_.by_id.size() || setup_.by_id[other.id].height_m == 0.0) continue;
    const Grain& grain = setup_.by_id[other.id];

    // c.bodies has the poses at the start of the step; the motion since is in c.motion.
    static constexpr SolverBody<double> still{};
    const SolverBody<double>& proxy_now = c.motion[proxy_is_a ? contact.slot_a : contact.slot_b];
    const SolverBody<double>& other_now =
        proxy_is_a ? (contact.b_fixed ? still : c.motion[contact.slot_b]) : c.motion[contact.slot_a];
    const Body& proxy = proxy_is_a ? a : b;
    const Vec3d offset = (proxy.motion.pose.position - other.motion.pose.position) +
                         (proxy_now.delta_position - other_now.delta_position);
    const Quatd rotation = other_now.delta_rotation * other.motion.pose.rotation;
    for (std::uint32_t i = 0; i < contact.count; ++i) {
      const ContactPoint& point = contact.points[i];
      const Vec3d& arm = proxy_is_a ? point.from_a : point.from_b;
      const Vec3d& n = contact.normal;
      Vec3d slip = velocity_at(proxy_now, arm) - velocity_at(other_now, offset + arm);
      slip -= dot(n, slip) * n;
      const double beats = norm(slip) * c.settings.dt / grain.wavelength_m;  // waves in a step
      const double share = std::clamp(2.0 - 4.0 * beats, 0.0, 1.0);
      const double pressed = point.total_normal_impulse / c.settings.dt;
      if (share * pressed == 0.0) continue;
      Vec3d force = (share * pressed) * rotate(rotation, downhill(grain, rotate_inverse(rotation, offset + arm)));
      force -= dot(n, force) * n;
      c.report.hand_wrench += Wrenchd{force, cross(arm, force)};
    }
  }
}

}  // namespace tactus::physics
