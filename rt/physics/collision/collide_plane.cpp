// The kernels of sphere, capsule and box against the half space below a plane. The plane is B; `up` is its outward
// normal.
#include "rt/physics/collision/collide.h"

namespace tactus::physics {
namespace {

Vec3d up_of(const PairView& pair) noexcept { return axes_of(pair.world_from_b).z; }

}  // namespace

void collide_sphere_plane(const PairView& pair, Manifold& manifold) noexcept {
  const Vec3d up = up_of(pair);
  const double separation = -dot(up, pair.b_from_a) - pair.a.radius;
  manifold.normal = -up;
  add_point(pair, manifold, up * -(pair.a.radius + 0.5 * separation), separation, 0);
}

// Adds both ends, so that a lying capsule has two points. Feature: 0 the end at -z, 1 the end at +z.
void collide_capsule_plane(const PairView& pair, Manifold& manifold) noexcept {
  const Vec3d up = up_of(pair), half = capsule_half_axis(pair.a, pair.world_from_a);
  manifold.normal = -up;
  const Vec3d ends[2] = {-half, half};
  for (std::uint32_t i = 0; i < 2; ++i) {
    const double separation = dot(up, ends[i] - pair.b_from_a) - pair.a.radius;
    add_point(pair, manifold, ends[i] - up * (pair.a.radius + 0.5 * separation), separation, i);
  }
}

// Adds the four corners of the face that points down most (the lower axis on a tie); the lowest corner is always one of
// them. The four lowest corners would be wrong: on a thin card they include the corners above the touching ones and
// miss the far edge. Feature: the corner, one bit per axis.
void collide_box_plane(const PairView& pair, Manifold& manifold) noexcept {
  const Vec3d up = up_of(pair);
  const Axes axes = axes_of(pair.world_from_a);
  const double tilt[3] = {dot(up, axes.x), dot(up, axes.y), dot(up, axes.z)};
  const Vec3d half[3] = {axes.x * pair.a.half_extents.x, axes.y * pair.a.half_extents.y,
                         axes.z * pair.a.half_extents.z};
  std::uint32_t down = 0;
  for (std::uint32_t i = 1; i < 3; ++i)
    if (std::abs(tilt[i]) > std::abs(tilt[down])) down = i;
  const std::uint32_t u = (down + 1) % 3, v = (down + 2) % 3;
  const bool positive = tilt[down] < 0.0;  // the face on the +axis side points down
  const Vec3d centre = positive ? half[down] : -half[down];
  manifold.normal = -up;
  for (std::uint32_t k = 0; k < 4; ++k) {
    const bool plus_u = (k & 1u) != 0, plus_v = (k & 2u) != 0;
    const Vec3d corner = centre + (plus_u ? half[u] : -half[u]) + (plus_v ? half[v] : -half[v]);
    const double separation = dot(up, corner - pair.b_from_a);
    const std::uint32_t feature =
        (std::uint32_t{positive} << down) | (std::uint32_t{plus_u} << u) | (std::uint32_t{plus_v} << v);
    add_point(pair, manifold, corner - up * (0.5 * separation), separation, feature);
  }
}

}  // namespace tactus::physics
