#include "sim/proxy_planes.h"

#include <algorithm>
#include <tuple>

namespace tactus::sim {
namespace {

using haptics::BorderPoint;

// The proxy's side of a point of one of its contacts; arms are of the start of the step.
BorderPoint plane_of(const physics::World<double>& world, const physics::Contact<double>& contact,
                     const physics::ContactPoint<double>& point, bool proxy_is_a, double step_s) noexcept {
  const auto bodies = world.bodies();
  const auto start = world.last_poses();
  const std::uint32_t proxy = proxy_is_a ? contact.slot_a : contact.slot_b;
  const std::uint32_t other = proxy_is_a ? contact.slot_b : contact.slot_a;
  const auto& outside = contact.b_fixed ? world.fixed_bodies()[other] : bodies[other];
  const Posed& outside_start = contact.b_fixed ? outside.motion.pose : start[other];
  const Vec3d anchor = rotate_inverse(outside_start.rotation, proxy_is_a ? point.from_b : point.from_a);
  BorderPoint plane;
  plane.member = bodies[proxy].id, plane.outside = outside.id, plane.feature = point.feature;
  plane.normal = proxy_is_a ? -contact.normal : contact.normal;
  plane.member_anchor = rotate_inverse(start[proxy].rotation, proxy_is_a ? point.from_a : point.from_b);
  plane.impulse_rate_N = point.total_normal_impulse / step_s;
  plane.friction = contact.friction;
  plane.outside_point = outside.motion.pose * anchor;
  plane.separation_m = point.separation;
  plane.outside_velocity = (plane.outside_point - outside_start * anchor) * (1.0 / step_s);
  return plane;
}

}  // namespace

void fill_proxy_planes(const physics::World<double>& world, BodyId proxy, double step_s, std::uint32_t most,
                       FixedVector<BorderPoint, haptics::kMaxBorderPoints>& planes) noexcept {
  planes.clear();
  for (const auto& contact : world.contacts()) {
    const bool is_a = world.bodies()[contact.slot_a].id == proxy;
    const bool is_b = !contact.b_fixed && world.bodies()[contact.slot_b].id == proxy;
    if (!is_a && !is_b) continue;
    for (std::uint32_t i = 0; i < contact.count; ++i)
      (void)planes.try_push(plane_of(world, contact, contact.points[i], is_a, step_s));
  }
  if (planes.size() <= most) return;
  std::sort(planes.begin(), planes.end(), [](const BorderPoint& a, const BorderPoint& b) {
    return std::tuple(-a.impulse_rate_N, a.separation_m, a.outside, a.feature) <
           std::tuple(-b.impulse_rate_N, b.separation_m, b.outside, b.feature);
  });
  planes.count = most;
}

}  // namespace tactus::sim
