#include "rt/physics/contact/start_impulses.h"

#include <algorithm>

namespace tactus::physics {
namespace {

constexpr std::uint32_t kNoPoint = kMaxManifoldPoints;

// Index of the point with the feature, of a manifold or a contact, or kNoPoint.
template <class Points>
std::uint32_t point_of(const Points& of, std::uint32_t feature) noexcept {
  for (std::uint32_t i = 0; i < of.count; ++i)
    if (of.points[i].feature == feature) return i;
  return kNoPoint;
}

// Index of the manifold's point nearest to `from_a`, from the centre of A.
std::uint32_t nearest_point(const Manifold& manifold, const Vec3d& from_a) noexcept {
  const auto distance = [&](const ManifoldPoint& p) noexcept { return norm_squared(p.from_a - from_a); };
  const auto first = manifold.points.begin();
  const auto nearest = std::min_element(first, first + manifold.count,
                                        [&](const auto& p, const auto& q) { return distance(p) < distance(q); });
  return static_cast<std::uint32_t>(nearest - first);
}

void add(double normal, const Vec3d& friction, const Tangents<double>& along, StartImpulse& to) noexcept {
  to.normal += normal;
  to.tangent[0] += dot(friction, along.t1);
  to.tangent[1] += dot(friction, along.t2);
}

}  // namespace

StartImpulses start_impulses(const Manifold& manifold, const Contact& last, double impulse_scale) noexcept {
  StartImpulses start{};
  // The normal has rotated since: projects the old friction vector on the new tangents.
  const Tangents<double> now = tangents_of(manifold.normal);
  const Tangents<double> then = last.normal == manifold.normal ? now : tangents_of(last.normal);
  const bool same_kind = is_of_face(last.points[0].feature) == is_of_face(manifold.points[0].feature);
  for (std::uint32_t j = 0; j < last.count; ++j) {
    const ContactPoint& before = last.points[j];
    std::uint32_t point = point_of(manifold, before.feature);
    if (point == kNoPoint && same_kind) point = nearest_point(manifold, before.from_a);
    if (point == kNoPoint) continue;
    add(impulse_scale * before.normal_impulse,
        impulse_scale * (before.tangent_impulse[0] * then.t1 + before.tangent_impulse[1] * then.t2), now, start[point]);
  }
  return start;
}

StartImpulses start_impulses(const Manifold& manifold, const WarmStart& given, double sub_step) noexcept {
  StartImpulses start{};
  const Tangents<double> now = tangents_of(manifold.normal);
  for (std::uint32_t j = 0; j < given.count; ++j)
    if (const std::uint32_t point = point_of(manifold, given.features[j]); point != kNoPoint)
      add(given.normal_force[j] * sub_step, given.friction_force[j] * sub_step, now, start[point]);
  return start;
}

void set_impulses(const WarmStart& given, double sub_step, Contact& contact) noexcept {
  const Tangents<double> along = tangents_of(contact.normal);
  for (std::uint32_t j = 0; j < given.count; ++j) {
    const std::uint32_t i = point_of(contact, given.features[j]);
    if (i == kNoPoint) continue;
    StartImpulse start;
    add(given.normal_force[j] * sub_step, given.friction_force[j] * sub_step, along, start);
    contact.points[i].normal_impulse = start.normal;
    contact.points[i].tangent_impulse[0] = start.tangent[0];
    contact.points[i].tangent_impulse[1] = start.tangent[1];
  }
}

}  // namespace tactus::physics
