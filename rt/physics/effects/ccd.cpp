#include "rt/physics/effects/ccd.h"

#include <algorithm>

#include "rt/physics/body_search.h"
#include "rt/physics/collision/collide.h"

namespace tactus::physics {
namespace {

// The device pulls at the proxy within the step: from this part of the margin on it is watched.
template <class T>
inline constexpr T kSafePart = T(0.5);

template <class T>
T surface_speed(const Body<T>& body, const Vec3<T>& v, const Vec3<T>& w) noexcept {
  return norm(v) + norm(w) * bounding_radius(body.shape);
}

template <class T>
Pose<T> pose_now(const Body<T>& body, const SolverBody<T>& state) noexcept {
  return {body.motion.pose.position + state.delta_position, state.delta_rotation * body.motion.pose.rotation};
}

}  // namespace

template <class T>
void ContinuousCollision<T>::enter(StageTable<T>& table) noexcept {
  table.template add<&ContinuousCollision::look_around>(Phase::kPrepare, *this);
  table.template add<&ContinuousCollision::hold_back>(Phase::kBiased, *this);
}

template <class T>
void ContinuousCollision<T>::look_around(StageContext<T>& c) noexcept {
  near_.clear();
  proxy_ = find_slot<T>(c.bodies, setup_.proxy);
  if (proxy_ == kNoSlot || c.held[proxy_] != 0) return;
  const Body<T>& proxy = c.bodies[proxy_];
  const T dt = c.settings.dt, reach = dt * surface_speed(proxy, c.motion[proxy_].v, c.motion[proxy_].w);
  if (reach < kSafePart<T> * c.settings.max_margin) return;
  const auto look_at = [&](const Body<T>& body, std::uint32_t slot, bool fixed, T its_reach) noexcept {
    const T apart = norm(body.motion.pose.position - proxy.motion.pose.position);
    const T distance = apart - bounding_radius(body.shape) - bounding_radius(proxy.shape);
    if (distance <= T(2) * reach + its_reach) add(c, {slot, fixed, distance});
  };
  for (std::uint32_t f = 0; f < c.fixed_bodies.size(); ++f)
    if (c.fixed_bodies[f].shape.kind != ShapeKind::kMesh) look_at(c.fixed_bodies[f], f, true, T(0));
  for (std::uint32_t i = 0; i < c.bodies.size(); ++i)
    if (i != proxy_) look_at(c.bodies[i], i, false, dt * surface_speed(c.bodies[i], c.motion[i].v, c.motion[i].w));
}

template <class T>
void ContinuousCollision<T>::add(StageContext<T>& c, const Near& near) noexcept {
  if (near_.try_push(near)) return;
  c.report.capacity_bits |= kPairsFull;
  ++c.report.dropped;
  Near& farthest = *std::max_element(near_.begin(), near_.end(),
                                     [](const Near& p, const Near& q) { return p.distance < q.distance; });
  if (near.distance < farthest.distance) farthest = near;
}

template <class T>
void ContinuousCollision<T>::hold_back(StageContext<T>& c) noexcept {
  static constexpr SolverBody<T> still{};
  for (const Near& near : near_) {
    const Body<T>&a = c.bodies[proxy_], &b = near.fixed ? c.fixed_bodies[near.slot] : c.bodies[near.slot];
    SolverBody<T>& state_a = c.motion[proxy_];
    const SolverBody<T>& state_b = near.fixed ? still : c.motion[near.slot];
    const Pose<T> pose_b = near.fixed ? b.motion.pose : pose_now(b, state_b);
    const T turning =
        (near.fixed ? T(0) : norm(state_b.w) * bounding_radius(b.shape)) + norm(state_a.w) * bounding_radius(a.shape);
    const T reach = c.h * (norm(state_b.v - state_a.v) + turning);
    AxisCache cache;
    const Manifold<T> manifold = collide(a.shape, pose_now(a, state_a), b.shape, pose_b, reach, cache, setup_.hulls);
    for (std::uint32_t i = 0; i < manifold.count; ++i) {
      const ManifoldPoint<T>& point = manifold.points[i];
      const Vec3<T>& n = manifold.normal;
      const T closing = dot(n, velocity_at(state_a, point.from_a) - velocity_at(state_b, point.from_b));
      const T excess = closing - std::max(T(0), point.separation) / c.h;
      if (excess <= T(0)) continue;
      T inverse = inverse_effective_mass(state_a.inverse_mass, c.inverse_inertia[proxy_], point.from_a, n, n);
      if (!near.fixed)
        inverse += inverse_effective_mass(state_b.inverse_mass, c.inverse_inertia[near.slot], point.from_b, n, n);
      const Vec3<T> p = (excess * invert_or_zero(inverse)) * n;
      apply_impulse_at(state_a, c.inverse_inertia[proxy_], point.from_a, -p);
      if (!near.fixed) apply_impulse_at(c.motion[near.slot], c.inverse_inertia[near.slot], point.from_b, p);
    }
  }
}

template class ContinuousCollision<double>;
template class ContinuousCollision<float>;

}  // namespace tactus::physics
