#include "rt/physics/integrate.h"

#include "rt/physics/contact/body_lanes.h"

namespace tactus::physics {

// The exponential map by the series of cos and sin(x)/x in x = angle / 2, to x^8. For angles below kSmallAngle the
// first omitted term is below 3e-20.
template <class V>
TACTUS_INLINE Quat<V> small_rotation(const Vec3<V>& v, const V& angle_squared) noexcept {
  const auto number = [](double x) noexcept { return V(static_cast<LaneOf<V>>(x)); };
  const V one(1), x2 = number(0.25) * angle_squared;
  const V c =
      one - x2 * (number(1.0 / 2) - x2 * (number(1.0 / 24) - x2 * (number(1.0 / 720) - x2 * number(1.0 / 40320))));
  const V s =
      one - x2 * (number(1.0 / 6) - x2 * (number(1.0 / 120) - x2 * (number(1.0 / 5040) - x2 * number(1.0 / 362880))));
  const V k = number(0.5) * s;
  return {c, k * v.x, k * v.y, k * v.z};
}
template <class T>
inline constexpr T kSmallAngleSquared = T(0.01);  // rad^2

template <class T>
FreeRotation<T> rotate_steadily(const Vec3<T>& angular_velocity, T h) noexcept {
  const Vec3<T> v = h * angular_velocity;
  const T angle_squared = norm_squared(v);
  // The usual case, several times faster than the general one.
  if (angle_squared < kSmallAngleSquared<T>) return {small_rotation(v, angle_squared), angular_velocity};
  return {quat_from_rotation_vector(v), angular_velocity};
}

// Beyond this angle per sub-step the iteration below need not converge.
template <class T>
inline constexpr T kMaxTurnSquared = T(0.25);  // rad^2

// The iteration, on one body or on several.
template <class V>
TACTUS_INLINE FreeRotation<V> iterate_freely(const Quat<V>& world_from_body, const Vec3<V>& angular_velocity,
                                             const Vec3<V>& inertia, V h) noexcept {
  using std::sqrt;
  const V one(1), half_of(LaneOf<V>(0.5));
  const Vec3<V> w0 = rotate_inverse(world_from_body, angular_velocity);
  const Vec3<V> gain{h / inertia.x, h / inertia.y, h / inertia.z};
  Vec3<V> w1 = w0, mid = w0;
  for (int i = 0; i < 4; ++i) {
    w1 = w0 - scale(gain, cross(mid, scale(inertia, mid)));
    mid = half_of * (w0 + w1);
  }
  const Vec3<V> half = rotate(world_from_body, half_of * h * mid);
  const V s = one / sqrt(one + half.x * half.x + half.y * half.y + half.z * half.z);
  const Quat<V> change{s, half.x * s, half.y * s, half.z * s};
  return {change, rotate(change, rotate(world_from_body, w1))};
}

template <class T>
FreeRotation<T> rotate_freely(const Quat<T>& world_from_body, const Vec3<T>& angular_velocity, const Vec3<T>& inertia,
                              T h) noexcept {
  if (!(h * h * norm_squared(angular_velocity) < kMaxTurnSquared<T>)) return rotate_steadily(angular_velocity, h);
  return iterate_freely(world_from_body, angular_velocity, inertia, h);
}

namespace {

template <class T>
void move_one(SolverBody<T>& state, const Body& body, T h) noexcept {
  if (state.inverse_mass == T(0)) return;
  state.delta_position += h * state.v;
  if (state.gyroscopic > T(0)) {
    // The gyroscopic term is integrated together with the rotation, so that a free body keeps energy and momentum.
    const auto turned = rotate_freely(state.delta_rotation * number_cast<T>(body.motion.pose.rotation), state.w,
                                      number_cast<T>(body.inertia), h);
    state.delta_rotation = turned.change * state.delta_rotation;
    state.w = turned.angular_velocity;
  } else {
    state.delta_rotation = rotate_steadily(state.w, h).change * state.delta_rotation;
  }
}

// The rotations and inertias of consecutive bodies, one in each lane.
template <class V>
TACTUS_INLINE void read_frames(const Body* bodies, Quat<V>& rotation, Vec3<V>& inertia) noexcept {
  for (int lane = 0; lane < kLanes<V>; ++lane) {
    const auto q = number_cast<LaneOf<V>>(bodies[lane].motion.pose.rotation);
    rotation.w.set(lane, q.w);
    rotation.x.set(lane, q.x);
    rotation.y.set(lane, q.y);
    rotation.z.set(lane, q.z);
    const auto i = number_cast<LaneOf<V>>(bodies[lane].inertia);
    inertia.x.set(lane, i.x);
    inertia.y.set(lane, i.y);
    inertia.z.set(lane, i.z);
  }
}

// Like move_one on each body, bit for bit. If one of them needs the general case, returns false and changes nothing.
template <class V, class T>
bool move_together(SolverBody<T>* motion, const Body* bodies, T h) noexcept {
  std::uint32_t slot[kLanes<V>];
  for (int lane = 0; lane < kLanes<V>; ++lane) slot[lane] = static_cast<std::uint32_t>(lane);
  BodyLanes<V> b = BodyLanes<V>::read_all(motion, slot);
  const Vec3<V> v = V(h) * b.w;
  const V angle_squared = norm_squared(v);
  const auto freely = b.gyroscopic > V(0);
  const V limit = select(freely, V(kMaxTurnSquared<T>), V(kSmallAngleSquared<T>));
  if (any(limit <= angle_squared)) return false;
  Quat<V> change = small_rotation(v, angle_squared);
  if (any(freely)) {
    Quat<V> rotation;
    Vec3<V> inertia;
    read_frames(bodies, rotation, inertia);
    const FreeRotation<V> turned = iterate_freely(b.delta_rotation * rotation, b.w, inertia, V(h));
    change = {select(freely, turned.change.w, change.w), select(freely, turned.change.x, change.x),
              select(freely, turned.change.y, change.y), select(freely, turned.change.z, change.z)};
    b.w = {select(freely, turned.angular_velocity.x, b.w.x), select(freely, turned.angular_velocity.y, b.w.y),
           select(freely, turned.angular_velocity.z, b.w.z)};
  }
  b.delta_position += V(h) * b.v;
  b.delta_rotation = change * b.delta_rotation;
  b.write_all(motion, slot);
  return true;
}

}  // namespace

template <class T>
void move_bodies(std::span<SolverBody<T>> motion, std::span<const Body> bodies, T h) noexcept {
  constexpr std::size_t kTogether = kLanes<Register<T>>;
  std::size_t i = 0;
  for (; i + kTogether <= motion.size(); i += kTogether) {
    if (move_together<Register<T>>(&motion[i], &bodies[i], h)) continue;
    for (std::size_t k = i; k < i + kTogether; ++k) move_one(motion[k], bodies[k], h);
  }
  for (; i < motion.size(); ++i) move_one(motion[i], bodies[i], h);
}

template void move_bodies(std::span<SolverBody<double>>, std::span<const Body>, double) noexcept;
template void move_bodies(std::span<SolverBody<float>>, std::span<const Body>, float) noexcept;
template FreeRotation<double> rotate_freely(const Quatd&, const Vec3d&, const Vec3d&, double) noexcept;
template FreeRotation<float> rotate_freely(const Quat<float>&, const Vec3<float>&, const Vec3<float>&, float) noexcept;
template FreeRotation<double> rotate_steadily(const Vec3d&, double) noexcept;
template FreeRotation<float> rotate_steadily(const Vec3<float>&, float) noexcept;

}  // namespace tactus::physics
