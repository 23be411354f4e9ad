#include "sim/exchange/approach.h"

#include <algorithm>

#include "rt/physics/collision/collide_parts.h"
#include "rt/physics/collision/fixed_tree.h"
#include "rt/physics/contact/find_contacts.h"
#include "rt/physics/contact/rolling_side.h"

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

bool touches_now(const physics::World& world, PairKey key) noexcept {
  const auto* contact = physics::find_contact(world.contacts(), key);
  return contact != nullptr && contact->touching();
}

}  // namespace

Approach::Approach(std::uint32_t max_bodies) {
  found_.reserve(kMaxApproaches);
  members_.reserve(max_bodies);
  others_.reserve(max_bodies);
}

std::span<const Approaching> Approach::find(const physics::World& world, std::span<const std::uint8_t> members,
                                            double horizon_s) noexcept {
  const std::span<const Body> bodies = world.bodies();
  members_.clear();
  others_.clear();
  found_.clear();
  const auto moving = [&](std::uint32_t slot) noexcept -> Moving {
    const double reach = reach_of(bodies[slot], horizon_s);
    return {physics::SlotIndex{slot}, reach, physics::bounds_of(bodies[slot].shape, bodies[slot].motion.pose, reach)};
  };
  double farthest = 0;
  physics::Aabb all;
  for (std::uint32_t slot = 0; slot < bodies.size(); ++slot) {
    if (members[slot] == 0) continue;
    members_.push_back(moving(slot));
    all = members_.size() == 1 ? members_[0].box : join(all, members_.back().box);
    farthest = std::max(farthest, members_.back().reach_m);
  }
  if (members_.empty()) return found_;
  for (std::uint32_t slot = 0; slot < bodies.size(); ++slot) {
    if (members[slot] != 0) continue;
    const double radius = physics::bounding_radius(bodies[slot].shape), reach = reach_of(bodies[slot], horizon_s);
    const Vec3d& at = bodies[slot].motion.pose.position;
    if (farthest + reach <= kMinReach_m || !all.grown(radius + reach).overlaps({at, at})) continue;
    others_.push_back(moving(slot));
  }
  for (const Moving& member : members_)
    for (const Moving& other : others_) {
      if (member.reach_m + other.reach_m <= kMinReach_m || !member.box.overlaps(other.box)) continue;
      if (member.slot < other.slot)
        compare(world, member, other, horizon_s);
      else
        compare(world, other, member, horizon_s);
      if (found_.size() == kMaxApproaches) return found_;
    }
  return found_;
}

// Keeps the points of each two parts that will meet.
void Approach::compare(const physics::World& world, const Moving& a, const Moving& b, double horizon_s) noexcept {
  const Body &body_a = world.body(a.slot), &body_b = world.body(b.slot);
  const auto& lists = world.shapes();
  const physics::PosedShape shape_a = posed_shape(body_a), shape_b = posed_shape(body_b);
  const double margin = a.reach_m + b.reach_m;
  physics::for_each_near_parts(
      {shape_a, a.reach_m}, {shape_b, b.reach_m}, lists, [&](std::uint32_t i, std::uint32_t j) noexcept {
        if (touches_now(world, PairKey::of(BodyPart{body_a.id, i}, BodyPart{body_b.id, j}, false))) return;
        physics::AxisCache cache;
        auto manifold =
            physics::collide_parts(part_of(shape_a, i, lists.compounds), part_of(shape_b, j, lists.compounds),
                                   {.margin = margin}, cache, lists.hulls);
        std::uint32_t meet = 0;
        for (std::uint32_t k = 0; k < manifold.count; ++k) {
          const physics::ManifoldPoint point = manifold.points[k];
          const Vec3d at = body_a.motion.pose.position + point.from_a;
          const double closing = dot(velocity_at(body_a, at) - velocity_at(body_b, at), manifold.normal);
          if (point.separation < horizon_s * closing) manifold.points[meet++] = point;
        }
        manifold.count = meet;
        if (meet == 0 || found_.size() == kMaxApproaches) return;
        const double separation = manifold.points[0].separation;
        found_.push_back({.a = a.slot,
                          .b = b.slot,
                          .part_a = i,
                          .part_b = j,
                          .manifold = manifold,
                          .round_a = physics::round_at(part_shape(body_a.shape, i, lists.compounds), separation),
                          .round_b = physics::round_at(part_shape(body_b.shape, j, lists.compounds), separation)});
      });
}

}  // namespace tactus::sim
