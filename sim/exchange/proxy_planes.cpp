#include "sim/exchange/proxy_planes.h"

#include <algorithm>
#include <tuple>

#include "sim/exchange/border_exchange.h"

namespace tactus::sim {
namespace {

using haptics::BorderPoint;

// The proxy's side of a point of one of its contacts; the other body may be fixed.
BorderPoint plane_of(const physics::World& world, const physics::Contact& contact, const physics::ContactPoint& point,
                     bool proxy_is_a, double step_s) noexcept {
  const auto bodies = world.bodies();
  const auto start = world.last_poses();
  const std::uint32_t proxy = proxy_is_a ? contact.slot_a : contact.slot_b;
  const std::uint32_t other = proxy_is_a ? contact.slot_b : contact.slot_a;
  const auto& outside = contact.b_fixed ? world.fixed_bodies()[other] : bodies[other];
  return border_point(contact, point, proxy_is_a, {bodies[proxy], start[proxy]},
                      {outside, contact.b_fixed ? outside.motion.pose : start[other]}, step_s);
}

}  // namespace

void fill_proxy_planes(const physics::World& world, BodyId proxy, double step_s, std::uint32_t most,
                       FixedVector<BorderPoint, haptics::kMaxBorderPoints>& planes) noexcept {
  planes.clear();
  for (const auto& contact : world.contacts()) {
    const bool is_a = world.bodies()[contact.slot_a].id == proxy;
    const bool is_b = !contact.b_fixed && world.bodies()[contact.slot_b].id == proxy;
    if (!is_a && !is_b) continue;
    for (std::uint32_t i = 0; i < contact.count; ++i)
      if (!contact.points[i].redundant)
        (void)planes.try_push(plane_of(world, contact, contact.points[i], is_a, step_s));
  }
  if (planes.size() <= most) return;
  std::sort(planes.begin(), planes.end(), [](const BorderPoint& a, const BorderPoint& b) {
    return std::tuple(-a.impulse_rate_N, a.separation_m, a.outside, a.parts, a.feature) <
           std::tuple(-b.impulse_rate_N, b.separation_m, b.outside, b.parts, b.feature);
  });
  planes.count = most;
}

}  // namespace tactus::sim
