#include "rt/physics/contact/contact_reference.h"

#include <algorithm>

namespace tactus::physics {
namespace {

template <class T>
constexpr T thinnest(const Vec3<T>& half_extents) noexcept {
  return std::min({half_extents.x, half_extents.y, half_extents.z});
}

// The four points side by side: loops over the lanes are what the compiler makes wide.
template <class T>
struct Lanes {
  static constexpr std::uint32_t kCount = ContactReference<T>::kPoints;
  T x[kCount], y[kCount], z[kCount];
};

template <class T>
[[gnu::always_inline]] inline Lanes<T> to_world(const Axes<T>& axes, const T (&p)[3][Lanes<T>::kCount]) noexcept {
  Lanes<T> out;
  for (std::uint32_t i = 0; i < Lanes<T>::kCount; ++i) {
    out.x[i] = axes.x.x * p[0][i] + axes.y.x * p[1][i] + axes.z.x * p[2][i];
    out.y[i] = axes.x.y * p[0][i] + axes.y.y * p[1][i] + axes.z.y * p[2][i];
    out.z[i] = axes.x.z * p[0][i] + axes.y.z * p[1][i] + axes.z.z * p[2][i];
  }
  return out;
}

}  // namespace

template <class T>
T tolerance_of(PairKey key, const Shape<T>& a, const Shape<T>& b, T most) noexcept {
  const T whole = std::min(most, T(0.01) * std::min(thinnest(a.half_extents), thinnest(b.half_extents)));
  const std::uint64_t mixed = key.value * 0x9e3779b97f4a7c15ull;  // 2^64 / golden ratio: neighbours land far apart
  return whole * (T(1) - static_cast<T>(mixed >> 56) / T(512));
}

template <class T>
void keep_reference(const Contact<T>& contact, const BodyFrame<T>& a, const BodyFrame<T>& b, T margin, T tolerance,
                    T lever, ContactReference<T>& reference) noexcept {
  reference = {};
  reference.tolerance = tolerance, reference.margin = margin, reference.lever = lever;
  for (std::uint32_t i = 0; i < contact.count; ++i) {
    const ContactPoint<T>& point = contact.points[i];
    reference.on_a[0][i] = dot(a.axes.x, point.from_a), reference.on_b[0][i] = dot(b.axes.x, point.from_b);
    reference.on_a[1][i] = dot(a.axes.y, point.from_a), reference.on_b[1][i] = dot(b.axes.y, point.from_b);
    reference.on_a[2][i] = dot(a.axes.z, point.from_a), reference.on_b[2][i] = dot(b.axes.z, point.from_b);
    reference.separation[i] = point.separation;
  }
}

template <class T>
void carry_over(const ContactReference<T>& reference, const BodyFrame<T>& a, const BodyFrame<T>& b,
                Contact<T>& contact) noexcept {
  const Vec3<T> offset = b.position - a.position, n = contact.normal;
  Lanes<T> on_a = to_world(a.axes, reference.on_a), on_b = to_world(b.axes, reference.on_b);
  T separation[Lanes<T>::kCount];
  for (std::uint32_t i = 0; i < Lanes<T>::kCount; ++i) {
    // How far apart the bodies carried the point; it is now midway.
    const T x = on_b.x[i] - on_a.x[i] + offset.x, y = on_b.y[i] - on_a.y[i] + offset.y,
            z = on_b.z[i] - on_a.z[i] + offset.z;
    separation[i] = reference.separation[i] + (n.x * x + n.y * y + n.z * z);
    on_a.x[i] += T(0.5) * x, on_a.y[i] += T(0.5) * y, on_a.z[i] += T(0.5) * z;
    on_b.x[i] -= T(0.5) * x, on_b.y[i] -= T(0.5) * y, on_b.z[i] -= T(0.5) * z;
  }
  for (std::uint32_t i = 0; i < contact.count; ++i) {
    ContactPoint<T>& point = contact.points[i];
    point.from_a = {on_a.x[i], on_a.y[i], on_a.z[i]};
    point.from_b = {on_b.x[i], on_b.y[i], on_b.z[i]};
    point.separation = separation[i];
    point.total_normal_impulse = T(0), point.total_friction = {};
  }
}

#define TACTUS_INSTANTIATE(T)                                                                           \
  template T tolerance_of<T>(PairKey, const Shape<T>&, const Shape<T>&, T) noexcept;                    \
  template void keep_reference<T>(const Contact<T>&, const BodyFrame<T>&, const BodyFrame<T>&, T, T, T, \
                                  ContactReference<T>&) noexcept;                                       \
  template void carry_over<T>(const ContactReference<T>&, const BodyFrame<T>&, const BodyFrame<T>&,     \
                              Contact<T>&) noexcept;
TACTUS_INSTANTIATE(double)
TACTUS_INSTANTIATE(float)
#undef TACTUS_INSTANTIATE

}  // namespace tactus::physics
