#include "rt/physics/effects/ccd.h"

#include <algorithm>

#include "rt/physics/body_search.h"
#include "rt/physics/collision/collide_parts.h"

namespace tactus::physics {
namespace {

// The device may accelerate the proxy within the step, so the effect is active from this share of the margin on.
inline constexpr double kSafePart = 0.5;
constexpr SolverBody<double> kStill{};  // of a fixed body

double surface_speed(const Body& body, const Vec3d& v, const Vec3d& w) noexcept {
  return norm(v) + norm(w) * bounding_radius(body.shape);
}

Posed pose_now(const Body& body, const SolverBody<double>& state) noexcept {
  return {body.motion.pose.position + state.delta_position, state.delta_rotation * body.motion.pose.rotation};
}

}  // namespace

void ContinuousCollision::register_stages(StageTable& table) noexcept {
  table.add<&ContinuousCollision::look_around>(Phase::kPrepare, *this);
  table.add<&ContinuousCollision::hold_back>(Phase::kBiased, *this);
}

void ContinuousCollision::look_around(StageContext& c) noexcept {
  near_.clear();
  proxy_ = find_slot(c.bodies, setup_.proxy);
  if (proxy_ == kNoSlot || c.frozen[proxy_] != 0) return;
  const Body& proxy = c.bodies[proxy_];
  const double dt = c.settings.dt, reach = dt * surface_speed(proxy, c.motion[proxy_].v, c.motion[proxy_].w);
  if (reach < kSafePart * c.settings.max_margin) return;
  const auto look_at = [&](const Body& body, std::uint32_t slot, bool fixed, double its_reach) noexcept {
    const double apart = norm(body.motion.pose.position - proxy.motion.pose.position);
    const double distance = apart - bounding_radius(body.shape) - bounding_radius(proxy.shape);
    if (distance <= 2.0 * reach + its_reach) add(c, {slot, fixed, distance});
  };
  for (std::uint32_t f = 0; f < c.fixed_bodies.size(); ++f)
    if (c.fixed_bodies[f].shape.kind != ShapeKind::kMesh) look_at(c.fixed_bodies[f], f, true, 0.0);
  for (std::uint32_t i = 0; i < c.bodies.size(); ++i)
    if (i != proxy_) look_at(c.bodies[i], i, false, dt * surface_speed(c.bodies[i], c.motion[i].v, c.motion[i].w));
}

void ContinuousCollision::add(StageContext& c, const Near& near) noexcept {
  if (near_.try_push(near)) return;
  c.report.capacity_bits |= kPairsFull;
  ++c.report.dropped;
  Near& farthest = *std::max_element(near_.begin(), near_.end(),
                                     [](const Near& p, const Near& q) { return p.distance < q.distance; });
  if (near.distance < farthest.distance) farthest = near;
}

void ContinuousCollision::hold_back(StageContext& c) noexcept {
  for (const Near& near : near_) {
    const Body &a = c.bodies[proxy_], &b = near.fixed ? c.fixed_bodies[near.slot] : c.bodies[near.slot];
    const SolverBody<double>& state_a = c.motion[proxy_];
    const SolverBody<double>& state_b = near.fixed ? kStill : c.motion[near.slot];
    const Posed pose_a = pose_now(a, state_a), pose_b = near.fixed ? b.motion.pose : pose_now(b, state_b);
    const double surface_speed =
        (near.fixed ? 0.0 : norm(state_b.w) * bounding_radius(b.shape)) + norm(state_a.w) * bounding_radius(a.shape);
    const double reach = c.h * (norm(state_b.v - state_a.v) + surface_speed);
    for_each_manifold(
        {a.shape, pose_a}, {b.shape, pose_b}, reach, setup_.shapes,
        [&](std::uint32_t, std::uint32_t, const Manifold& manifold) noexcept { hold_back_at(near, manifold, c); });
  }
}

void ContinuousCollision::hold_back_at(const Near& near, const Manifold& manifold, StageContext& c) noexcept {
  SolverBody<double>& state_a = c.motion[proxy_];
  const SolverBody<double>& state_b = near.fixed ? kStill : c.motion[near.slot];
  for (std::uint32_t i = 0; i < manifold.count; ++i) {
    const ManifoldPoint& point = manifold.points[i];
    const Vec3d& n = manifold.normal;
    const double closing = dot(n, velocity_at(state_a, point.from_a) - velocity_at(state_b, point.from_b));
    const double excess = closing - std::max(0.0, point.separation) / c.h;
    if (excess <= 0.0) continue;
    double inverse = inverse_effective_mass(state_a.inverse_mass, c.inverse_inertia[proxy_], point.from_a, n, n);
    if (!near.fixed)
      inverse += inverse_effective_mass(state_b.inverse_mass, c.inverse_inertia[near.slot], point.from_b, n, n);
    const Vec3d p = (excess * invert_or_zero(inverse)) * n;
    apply_impulse_at(state_a, c.inverse_inertia[proxy_], point.from_a, -p);
    if (!near.fixed) apply_impulse_at(c.motion[near.slot], c.inverse_inertia[near.slot], point.from_b, p);
  }
}

}  // namespace tactus::physics
