#include "sim/exchange/approach.h"

#include <algorithm>

#include "rt/physics/collision/collide.h"
#include "rt/physics/collision/fixed_tree.h"
#include "rt/physics/contact/find_contact.h"

namespace tactus::sim {
namespace {

using physics::Body;

// Pairs that cannot close by more than this are skipped: the contacts find them, with a margin as wide
// (StepSettings::min_margin).
constexpr double kMinReach_m = 5e-4;

double reach_of(const Body& body, double horizon_s) noexcept {
  const Twistd& v = body.motion.velocity;
  return horizon_s * (norm(v.linear) + norm(v.angular) * physics::bounding_radius(body.shape));
}

Vec3d velocity_at(const Body& body, const Vec3d& point) noexcept {
  return body.motion.velocity.linear + cross(body.motion.velocity.angular, point - body.motion.pose.position);
}

bool touches_now(const physics::World& world, BodyId a, BodyId b) noexcept {
  const auto* contact = physics::find_contact(world.contacts(), a, b);
  return contact != nullptr && contact->touching();
}

}  // namespace

Approach::Approach(std::uint32_t max_bodies) {
  members_.reserve(max_bodies);
  others_.reserve(max_bodies);
}

void Approach::find(const physics::World& world, physics::Hulls hulls, std::span<const std::uint8_t> members,
                    std::span<const BodyIndex> awake, double horizon_s, std::vector<ContactEdge>& touches) noexcept {
  const std::span<const Body> bodies = world.bodies();
  members_.clear();
  others_.clear();
  const auto moving = [&](std::uint32_t slot) noexcept -> Moving {
    const double reach = reach_of(bodies[slot], horizon_s);
    return {slot, reach, physics::bounds_of(bodies[slot].shape, bodies[slot].motion.pose, reach)};
  };
  double farthest = 0;
  physics::Aabb all;
  for (std::uint32_t slot = 0; slot < bodies.size(); ++slot) {
    if (members[slot] == 0) continue;
    members_.push_back(moving(slot));
    all = members_.size() == 1 ? members_[0].box : join(all, members_.back().box);
    farthest = std::max(farthest, members_.back().reach_m);
  }
  if (members_.empty()) return;
  for (std::uint32_t slot = 0; slot < bodies.size(); ++slot) {
    if (members[slot] != 0) continue;
    const double radius = physics::bounding_radius(bodies[slot].shape), reach = reach_of(bodies[slot], horizon_s);
    const Vec3d& at = bodies[slot].motion.pose.position;
    if (farthest + reach <= kMinReach_m || !all.grown(radius + reach).overlaps({at, at})) continue;
    others_.push_back(moving(slot));
  }
  for (const Moving& member : members_)
    for (const Moving& other : others_) {
      const double margin = member.reach_m + other.reach_m;
      if (margin <= kMinReach_m || !member.box.overlaps(other.box)) continue;
      const Moving &a = member.slot < other.slot ? member : other, &b = member.slot < other.slot ? other : member;
      const Body &body_a = bodies[a.slot], &body_b = bodies[b.slot];
      if (touches_now(world, body_a.id, body_b.id)) continue;
      physics::AxisCache cache;
      const auto manifold =
          physics::collide(body_a.shape, body_a.motion.pose, body_b.shape, body_b.motion.pose, margin, cache, hulls);
      for (std::uint32_t i = 0; i < manifold.count; ++i) {
        const Vec3d point = body_a.motion.pose.position + manifold.points[i].from_a;
        const double closing = dot(velocity_at(body_a, point) - velocity_at(body_b, point), manifold.normal);
        if (!(manifold.points[i].separation < closing * horizon_s)) continue;
        if (touches.size() == touches.capacity()) return;
        touches.push_back(
            {.a = awake[a.slot], .b = awake[b.slot], .point = point, .normal = manifold.normal, .joined = false});
        break;
      }
    }
}

}  // namespace tactus::sim
