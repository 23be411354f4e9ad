#include "rt/physics/contact/contact_reference.h"

#include <algorithm>

namespace tactus::physics {
namespace {

constexpr double thinnest(const Vec3d& half_extents) noexcept {
  return std::min({half_extents.x, half_extents.y, half_extents.z});
}

// The four points in parallel lanes, so that the compiler vectorises the loops.
struct Lanes {
  static constexpr std::uint32_t kCount = ContactReference::kPoints;
  double x[kCount], y[kCount], z[kCount];
};

[[gnu::always_inline]] inline Lanes to_world(const Axes& axes, const double (&p)[3][Lanes::kCount]) noexcept {
  Lanes out;
  for (std::uint32_t i = 0; i < Lanes::kCount; ++i) {
    out.x[i] = axes.x.x * p[0][i] + axes.y.x * p[1][i] + axes.z.x * p[2][i];
    out.y[i] = axes.x.y * p[0][i] + axes.y.y * p[1][i] + axes.z.y * p[2][i];
    out.z[i] = axes.x.z * p[0][i] + axes.y.z * p[1][i] + axes.z.z * p[2][i];
  }
  return out;
}

}  // namespace

double tolerance_of(PairKey key, const Shape& a, const Shape& b, double most) noexcept {
  const double whole = std::min(most, 0.01 * std::min(thinnest(a.half_extents), thinnest(b.half_extents)));
  const std::uint64_t ids =
      (static_cast<std::uint64_t>(key.with_fixed()) << 63) | (static_cast<std::uint64_t>(key.low()) << 31) | key.high();
  const std::uint64_t mixed = (ids ^ (static_cast<std::uint64_t>(key.parts()) << 40)) *
                              0x9e3779b97f4a7c15ull;  // 2^64 / golden ratio: spreads neighbouring keys
  return whole * (1.0 - static_cast<double>(mixed >> 56) / 512.0);
}

void store_anchors(const Contact& contact, const BodyFrame& a, const BodyFrame& b,
                   ContactReference& reference) noexcept {
  for (std::uint32_t i = 0; i < contact.count; ++i) {
    const ContactPoint& point = contact.points[i];
    reference.on_a[0][i] = dot(a.axes.x, point.from_a);
    reference.on_b[0][i] = dot(b.axes.x, point.from_b);
    reference.on_a[1][i] = dot(a.axes.y, point.from_a);
    reference.on_b[1][i] = dot(b.axes.y, point.from_b);
    reference.on_a[2][i] = dot(a.axes.z, point.from_a);
    reference.on_b[2][i] = dot(b.axes.z, point.from_b);
    reference.separation[i] = point.separation;
  }
}

void carry_over(const ContactReference& reference, const BodyFrame& a, const BodyFrame& b, Contact& contact) noexcept {
  const Vec3d offset = b.position - a.position, n = contact.normal;
  Lanes on_a = to_world(a.axes, reference.on_a), on_b = to_world(b.axes, reference.on_b);
  double separation[Lanes::kCount];
  for (std::uint32_t i = 0; i < Lanes::kCount; ++i) {
    // Separation of the two anchors of the point; the point is midway between them.
    const double x = on_b.x[i] - on_a.x[i] + offset.x, y = on_b.y[i] - on_a.y[i] + offset.y,
                 z = on_b.z[i] - on_a.z[i] + offset.z;
    separation[i] = reference.separation[i] + (n.x * x + n.y * y + n.z * z);
    on_a.x[i] += 0.5 * x;
    on_a.y[i] += 0.5 * y;
    on_a.z[i] += 0.5 * z;
    on_b.x[i] -= 0.5 * x;
    on_b.y[i] -= 0.5 * y;
    on_b.z[i] -= 0.5 * z;
  }
  for (std::uint32_t i = 0; i < contact.count; ++i) {
    ContactPoint& point = contact.points[i];
    point.from_a = {on_a.x[i], on_a.y[i], on_a.z[i]};
    point.from_b = {on_b.x[i], on_b.y[i], on_b.z[i]};
    point.separation = separation[i];
    point.total_normal_impulse = 0.0;
    point.total_friction = {};
  }
}

}  // namespace tactus::physics
