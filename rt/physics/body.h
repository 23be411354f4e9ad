// A rigid body: kind, shape, mass properties and motion. A plain value, the same in both worlds, in snapshots and on
// the tape.
// Units: SI. Frame: pose and velocity of the centre of mass in the world; inertia in the body frame. Thread: [any].
#pragma once

#include "rt/base/ids.h"
#include "rt/physics/shapes/shape.h"

namespace tactus::physics {

enum class BodyKind : std::uint32_t {
  kDynamic = 0,  // moves under forces
  kFixed = 1,    // never moves: static geometry
};

struct BodyMotion {
  Posed pose;       // world_from_body
  Twistd velocity;  // world
  friend constexpr bool operator==(const BodyMotion&, const BodyMotion&) noexcept = default;
};

struct Body {
  BodyId id{kNoBody};
  BodyKind kind{BodyKind::kDynamic};
  Shape shape;
  double mass{};            // kg; 0 for a fixed body
  Vec3d inertia{};          // kg m^2, diagonal in the body frame; 0 for a fixed body
  double friction{};        // coefficient; a pair uses the geometric mean sqrt(f_a f_b)
  double gravity_scale{1};  // 1: full gravity, 0: none (the proxy: the device carries it)
  BodyMotion motion;
};

// A homogeneous dynamic body at rest.
inline Body make_dynamic_body(BodyId id, const Shape& shape, double mass, double friction,
                              const Posed& world_from_body) noexcept {
  return {.id = id,
          .kind = BodyKind::kDynamic,
          .shape = shape,
          .mass = mass,
          .inertia = inertia_of(shape, mass),
          .friction = friction,
          .gravity_scale = 1.0,
          .motion = {world_from_body, {}}};
}

inline Body make_fixed_body(BodyId id, const Shape& shape, double friction, const Posed& world_from_body) noexcept {
  return {.id = id,
          .kind = BodyKind::kFixed,
          .shape = shape,
          .mass = 0.0,
          .inertia = {},
          .friction = friction,
          .gravity_scale = 0.0,
          .motion = {world_from_body, {}}};
}

inline PosedShape posed_shape(const Body& body) noexcept { return {.shape = body.shape, .pose = body.motion.pose}; }

// Kinetic energy of a dynamic body [J].
inline double kinetic_energy(const Body& body) noexcept {
  const Vec3d w = rotate_inverse(body.motion.pose.rotation, body.motion.velocity.angular);
  return 0.5 * (body.mass * norm_squared(body.motion.velocity.linear) + dot(w, scale(body.inertia, w)));
}

static_assert(std::is_trivially_copyable_v<Body>);

}  // namespace tactus::physics
