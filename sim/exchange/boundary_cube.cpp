#include "sim/exchange/boundary_cube.h"

#include <algorithm>

namespace tactus::sim {

double reach_of_proxy_m(const ReachSettings& s, double proxy_radius_m) noexcept {
  const double cycle_s = s.ratio * s.tick_period_s;
  if (s.reach == Reach::kPaper) return cycle_s * s.max_speed_m_per_s;
  return 2 * cycle_s * (s.max_speed_m_per_s + s.max_angular_speed_rad_per_s * proxy_radius_m) + s.margin_m;
}

double reach_of_body_m(const ReachSettings& s, const Twistd& velocity, double body_radius_m) noexcept {
  if (s.reach == Reach::kPaper) return 0;
  return 2 * s.ratio * s.tick_period_s * (norm(velocity.linear) + norm(velocity.angular) * body_radius_m);
}

BoundaryCube::BoundaryCube(const ReachSettings& settings, BodySpan<const physics::Body> bodies, BodyIndex proxy)
    : settings_(settings),
      proxy_(proxy),
      proxy_reach_m_(reach_of_proxy_m(settings, physics::bounding_radius(bodies[proxy].shape))),
      radius_m_(bodies.size()) {
  for (const BodyIndex body : bodies.indices()) radius_m_[body] = physics::bounding_radius(bodies[body].shape);
  close_.reserve(bodies.size());
}

double BoundaryCube::half_side_m(const physics::Body& proxy, const Posed& world_from_proxy) const noexcept {
  const physics::Aabb box = physics::bounds_of(proxy.shape, world_from_proxy, 0.0);
  const Vec3d extents = box.upper - box.lower;
  // A proxy accelerated by a spring may exceed the device's maximum speed.
  const double thrown = reach_of_body_m(settings_, proxy.motion.velocity, radius_m_[proxy_]);
  return 0.5 * std::max(extents.x, std::max(extents.y, extents.z)) + std::max(proxy_reach_m_, thrown);
}

physics::Aabb BoundaryCube::region(const physics::Body& proxy, const Posed& world_from_proxy) const noexcept {
  const double half = half_side_m(proxy, world_from_proxy);
  const Vec3d side{half, half, half};
  return {world_from_proxy.position - side, world_from_proxy.position + side};
}

std::span<const CloseBody> BoundaryCube::find(BodySpan<const physics::Body> bodies, const Posed& world_from_proxy,
                                              std::span<const BodyIndex> among) noexcept {
  const physics::Aabb proxy = physics::bounds_of(bodies[proxy_].shape, world_from_proxy, 0.0);
  const physics::Aabb cube = region(bodies[proxy_], world_from_proxy);
  const Vec3d centre = world_from_proxy.position;
  const double half_side = half_side_m(bodies[proxy_], world_from_proxy);

  close_.clear();
  const std::size_t count = among.empty() ? bodies.size() : among.size();
  for (std::size_t k = 0; k < count; ++k) {
    const BodyIndex index = among.empty() ? BodyIndex{static_cast<std::uint32_t>(k)} : among[k];
    if (index == proxy_) continue;
    const auto& body = bodies[index];
    const Vec3d away = abs(body.motion.pose.position - centre);
    const double own_reach = reach_of_body_m(settings_, body.motion.velocity, radius_m_[index]);
    if (std::max(away.x, std::max(away.y, away.z)) > half_side + own_reach + radius_m_[index]) continue;
    const physics::Aabb box = physics::bounds_of(body.shape, body.motion.pose, own_reach);
    if (!box.overlaps(cube)) continue;
    const Vec3d below = proxy.lower - box.upper, above = box.lower - proxy.upper;
    const Vec3d gap{std::max(below.x, above.x), std::max(below.y, above.y), std::max(below.z, above.z)};
    close_.push_back({index, std::max(gap.x, std::max(gap.y, gap.z))});
  }
  std::sort(close_.begin(), close_.end(), [](const CloseBody& a, const CloseBody& b) {
    return a.gap_m != b.gap_m ? a.gap_m < b.gap_m : a.index < b.index;
  });
  return close_;
}

}  // namespace tactus::sim
