#include "rt/haptics/coupling/plane_projection.h"

#include <algorithm>
#include <array>
#include <limits>

namespace tactus::haptics {
namespace {

// Correction that a plane applies: m, or m/s for velocities.
struct Pull {
  double along_normal{0};
  Vec3d in_plane{};
};
using Pulls = std::array<Pull, kMaxProxyPlanes>;

Vec3d in_plane(const Vec3d& normal, const Vec3d& v) noexcept { return v - dot(normal, v) * normal; }

Vec3d clamp_norm(const Vec3d& v, double length) noexcept {
  const double own = norm(v);
  return own > length ? v * (length / own) : v;
}

double cone_of(const ProxyPlane& plane, const Pull& pull) noexcept {
  return plane.friction * std::max(0.0, pull.along_normal);
}

// Projected Gauss-Seidel over the planes, with the normal corrections bounded below by `least`.
Vec3d nearest(std::span<const ProxyPlane> planes, const Vec3d& wanted, double least, Pulls& pulls) noexcept {
  Vec3d at = wanted;
  pulls.fill({});
  for (unsigned sweep = 0; sweep < kPlaneSweeps; ++sweep)
    for (std::size_t i = 0; i < planes.size(); ++i) {
      const ProxyPlane& plane = planes[i];
      const Pull before = pulls[i];
      Pull& pull = pulls[i];
      pull.along_normal = std::max(least, before.along_normal + plane.offset - dot(plane.normal, at));
      at += (pull.along_normal - before.along_normal) * plane.normal;
      pull.in_plane = clamp_norm(before.in_plane + in_plane(plane.normal, plane.hold - at), cone_of(plane, pull));
      at += pull.in_plane - before.in_plane;
    }
  return at;
}

// Velocity after the planes that apply a correction: the normal component that they stop is removed; where friction
// holds, the tangential one is that of the surface.
Vec3d velocity_left(std::span<const ProxyPlane> planes, const Pulls& pulls, const Vec3d& velocity, double least,
                    HeldProxy& held) noexcept {
  ProxyPlanes stopping;
  for (std::size_t i = 0; i < planes.size(); ++i)
    if (pulls[i].along_normal != 0) (void)stopping.try_push({planes[i].normal, 0});
  held.touches = stopping.size() > 0;
  Pulls taken;
  Vec3d left = nearest(stopping.span(), velocity, least, taken);
  for (std::size_t i = 0; i < planes.size(); ++i) {
    const double cone = cone_of(planes[i], pulls[i]);
    if (cone <= 0) continue;
    // At the edge of the cone, within rounding: sliding.
    constexpr double kEdge = 1 - 1e-9;
    if (norm(pulls[i].in_plane) >= kEdge * cone) {
      held.slides = true;
    } else {
      left += in_plane(planes[i].normal, planes[i].surface_velocity - left);
    }
  }
  return left;
}

HeldProxy keep(std::span<const ProxyPlane> planes, const Vec3d& wanted, const Vec3d& velocity, double least) noexcept {
  Pulls pulls;
  HeldProxy held;
  held.position = nearest(planes, wanted, least, pulls);
  held.velocity = velocity_left(planes, pulls, velocity, least, held);
  return held;
}

}  // namespace

HeldProxy keep_above(std::span<const ProxyPlane> planes, const Vec3d& wanted, const Vec3d& velocity) noexcept {
  return keep(planes, wanted, velocity, 0);
}

HeldProxy keep_on(std::span<const ProxyPlane> planes, const Vec3d& wanted, const Vec3d& velocity) noexcept {
  HeldProxy held = keep(planes, wanted, velocity, -std::numeric_limits<double>::infinity());
  held.touches = !planes.empty();
  return held;
}

}  // namespace tactus::haptics
