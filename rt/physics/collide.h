// Inside narrow phase: what the pair kernels are given, and the kernels. Everybody else calls manifold.h.
//
// Frame: world axes, origin at the centre of A; so a world far from its origin loses nothing. Units: m.
// Thread: [any]; pure, bounded, no allocation. A kernel fills the manifold of a pair whose kinds are in the order of
// ShapeKind; the dispatcher mirrors the others. A kernel leaves count 0 where nothing is within the margin, also
// where a pose is not finite: every test is written so that a NaN fails it.
#pragma once

#include "rt/physics/body_frame.h"
#include "rt/physics/manifold.h"

namespace tactus::physics {

template <class T>
struct PairView {
  const Shape<T>& a;
  const Shape<T>& b;
  const Quat<T>& world_from_a;
  const Quat<T>& world_from_b;
  Vec3<T> b_from_a;  // m, from the centre of A to the centre of B, world axes
  T margin;          // m
};

// Below this two points give no direction [m]: far above rounding at arm's length, far below any shape.
template <class T>
inline constexpr T kNoDirection = T(1e-12);

// An end point of a capsule moves by less than this when a two-point contact stands for the exact one [m]: the
// solver's slop (10 um), so what is neglected is what is left alone anyway.
template <class T>
inline constexpr T kFlatTolerance = T(1e-5);

template <class T>
Vec3<T> direction_or(const Vec3<T>& v, const Vec3<T>& fallback) noexcept {
  const T length = norm(v);
  return length > kNoDirection<T> ? v * (T(1) / length) : fallback;
}

// `mid`: midway between the surfaces, from the centre of A.
template <class T>
void add_point(const PairView<T>& pair, Manifold<T>& manifold, const Vec3<T>& mid, T separation,
               std::uint32_t feature) noexcept {
  if (!(separation <= pair.margin) || manifold.count == kMaxManifoldPoints) return;
  manifold.points[manifold.count++] = {mid, mid - pair.b_from_a, separation, feature};
}

// The point between two round surfaces: `on_a`, `on_b` on their skeletons (centre, axis), radius 0 for a box.
template <class T>
void add_round_point(const PairView<T>& pair, Manifold<T>& manifold, const Vec3<T>& on_a, T radius_a,
                     const Vec3<T>& on_b, T radius_b, T separation, std::uint32_t feature) noexcept {
  const Vec3<T> surface_a = on_a + manifold.normal * radius_a, surface_b = on_b - manifold.normal * radius_b;
  add_point(pair, manifold, T(0.5) * (surface_a + surface_b), separation, feature);
}

// The capsule's axis in the world, as half vector: its ends are centre -+ half.
template <class T>
Vec3<T> capsule_half_axis(const Shape<T>& capsule, const Quat<T>& world_from_body) noexcept {
  return rotate(world_from_body, Vec3<T>{T(0), T(0), capsule.half_length});
}

template <class T>
void collide_sphere_sphere(const PairView<T>& pair, Manifold<T>& manifold) noexcept;
template <class T>
void collide_sphere_capsule(const PairView<T>& pair, Manifold<T>& manifold) noexcept;
template <class T>
void collide_capsule_capsule(const PairView<T>& pair, Manifold<T>& manifold) noexcept;
template <class T>
void collide_sphere_plane(const PairView<T>& pair, Manifold<T>& manifold) noexcept;
template <class T>
void collide_capsule_plane(const PairView<T>& pair, Manifold<T>& manifold) noexcept;
template <class T>
void collide_box_plane(const PairView<T>& pair, Manifold<T>& manifold) noexcept;
template <class T>
void collide_sphere_box(const PairView<T>& pair, Manifold<T>& manifold) noexcept;
template <class T>
void collide_capsule_box(const PairView<T>& pair, Manifold<T>& manifold) noexcept;
template <class T>
void collide_box_box(const PairView<T>& pair, Manifold<T>& manifold, AxisCache& cache) noexcept;

}  // namespace tactus::physics
