// A rigid body: what it is and where it is. One plain value, the same in both worlds, in snapshots and on the tape.
// Units: SI. Frame: pose and velocity of the centre of mass in the world; inertia in the body frame. Thread: [any].
#pragma once

#include "rt/base/ids.h"
#include "rt/physics/shapes/shape.h"

namespace tactus::physics {

enum class BodyKind : std::uint32_t {
  kDynamic = 0,  // moves under forces
  kFixed = 1,    // never moves: static geometry
};

template <class T>
struct BodyMotion {
  Pose<T> pose;       // world_from_body
  Twist<T> velocity;  // world
  friend constexpr bool operator==(const BodyMotion&, const BodyMotion&) noexcept = default;
};

template <class T>
struct Body {
  BodyId id{kNoBody};
  BodyKind kind{BodyKind::kDynamic};
  Shape<T> shape;
  T mass{};            // kg; 0 for a fixed body
  Vec3<T> inertia{};   // kg m^2, diagonal in the body frame; 0 for a fixed body
  T friction{};        // coefficient; a pair uses the geometric mean sqrt(f_a f_b)
  T gravity_scale{1};  // 1 falls, 0 floats: the proxy is carried by the device
  BodyMotion<T> motion;
};

// A homogeneous dynamic body at rest.
template <class T>
Body<T> make_dynamic_body(BodyId id, const Shape<T>& shape, T mass, T friction,
                          const Pose<T>& world_from_body) noexcept {
  return {id, BodyKind::kDynamic, shape, mass, inertia_of(shape, mass), friction, T(1), {world_from_body, {}}};
}

template <class T>
Body<T> make_fixed_body(BodyId id, const Shape<T>& shape, T friction, const Pose<T>& world_from_body) noexcept {
  return {id, BodyKind::kFixed, shape, T(0), {}, friction, T(0), {world_from_body, {}}};
}

// J, of a dynamic body.
template <class T>
T kinetic_energy(const Body<T>& body) noexcept {
  const Vec3<T> w = rotate_inverse(body.motion.pose.rotation, body.motion.velocity.angular);
  return T(0.5) * (body.mass * norm_squared(body.motion.velocity.linear) + dot(w, scale(body.inertia, w)));
}

static_assert(std::is_trivially_copyable_v<Body<double>>);

}  // namespace tactus::physics
