#include "rt/haptics/plane_coupling.h"

#include <algorithm>
#include <array>
#include <limits>

namespace tactus::haptics {
namespace {

using Pulls = std::array<double, kMaxProxyPlanes>;  // along each normal; m or m/s

// The nearest point to `wanted`, by one plane after the other: each pulls as far as it must, and no less than `least`.
Vec3d nearest(std::span<const ProxyPlane> planes, const Vec3d& wanted, double least, Pulls& pulls) noexcept {
  Vec3d at = wanted;
  pulls.fill(0);
  for (unsigned sweep = 0; sweep < kPlaneSweeps; ++sweep)
    for (std::size_t i = 0; i < planes.size(); ++i) {
      const double pull = std::max(least, pulls[i] + planes[i].offset - dot(planes[i].normal, at));
      at += (pull - pulls[i]) * planes[i].normal;
      pulls[i] = pull;
    }
  return at;
}

// The planes that hold, through the origin: what the velocity sees of them.
ProxyPlanes holding(std::span<const ProxyPlane> planes, const Pulls& pulls) noexcept {
  ProxyPlanes held;
  for (std::size_t i = 0; i < planes.size(); ++i)
    if (pulls[i] != 0) (void)held.try_push({planes[i].normal, 0});
  return held;
}

}  // namespace

ProxyPlanes planes_of(std::span<const physics::BorderContact<double>> contacts, const Quatd& rotation,
                      CouplingScheme scheme) noexcept {
  ProxyPlanes planes;
  for (const auto& contact : contacts) {
    if (scheme == CouplingScheme::kLinearised && contact.impulse_rate <= 0) continue;
    // The contact point of a proxy at x is x + arm; at line_point it was `gap` above the surface.
    const Vec3d arm = rotate(rotation, contact.member_anchor);
    if (!planes.try_push({contact.normal, dot(contact.normal, contact.line_point - arm) - contact.gap})) break;
  }
  return planes;
}

HeldProxy keep_above(std::span<const ProxyPlane> planes, const Vec3d& wanted, const Vec3d& velocity) noexcept {
  Pulls pulls;
  HeldProxy held;
  held.position = nearest(planes, wanted, 0, pulls);
  const ProxyPlanes touched = holding(planes, pulls);
  held.touches = touched.size() > 0;
  held.velocity = nearest(touched.span(), velocity, 0, pulls);
  return held;
}

HeldProxy keep_on(std::span<const ProxyPlane> planes, const Vec3d& wanted, const Vec3d& velocity) noexcept {
  constexpr double kEitherWay = -std::numeric_limits<double>::infinity();
  Pulls pulls;
  HeldProxy held;
  held.position = nearest(planes, wanted, kEitherWay, pulls);
  held.touches = !planes.empty();
  ProxyPlanes through_origin;
  for (const ProxyPlane& plane : planes) (void)through_origin.try_push({plane.normal, 0});
  held.velocity = nearest(through_origin.span(), velocity, kEitherWay, pulls);
  return held;
}

}  // namespace tactus::haptics
