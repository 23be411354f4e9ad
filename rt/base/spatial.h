// Pose, twist and wrench: the spatial quantities used across folders.
// Frame: world unless the variable's name says otherwise. Units: m, rad, m/s, rad/s, N, N m. Thread: [any].
#pragma once

#include "rt/base/math.h"

namespace tactus {

template <class T>
struct Pose {
  Vec3<T> position;  // m
  Quat<T> rotation;  // unit quaternion, target_from_source

  // Maps a point from the source frame to the target frame.
  constexpr Vec3<T> operator*(const Vec3<T>& point) const noexcept { return position + rotate(rotation, point); }
  friend constexpr Pose operator*(const Pose& a, const Pose& b) noexcept {
    return {a * b.position, a.rotation * b.rotation};
  }
  friend constexpr bool operator==(const Pose&, const Pose&) noexcept = default;
};

template <class T>
constexpr Pose<T> inverse(const Pose<T>& p) noexcept {
  return {-rotate_inverse(p.rotation, p.position), conjugate(p.rotation)};
}

template <class T>
struct Twist {
  Vec3<T> linear;   // m/s, of the body's centre of mass
  Vec3<T> angular;  // rad/s

  constexpr Twist& operator+=(const Twist& o) noexcept {
    linear += o.linear;
    angular += o.angular;
    return *this;
  }
  constexpr Twist& operator-=(const Twist& o) noexcept {
    linear -= o.linear;
    angular -= o.angular;
    return *this;
  }
  constexpr Twist& operator*=(T s) noexcept {
    linear *= s;
    angular *= s;
    return *this;
  }
  friend constexpr Twist operator+(Twist a, const Twist& b) noexcept { return a += b; }
  friend constexpr Twist operator-(Twist a, const Twist& b) noexcept { return a -= b; }
  friend constexpr Twist operator*(Twist a, T s) noexcept { return a *= s; }
  friend constexpr Twist operator*(T s, Twist a) noexcept { return a *= s; }
  friend constexpr bool operator==(const Twist&, const Twist&) noexcept = default;
};

template <class T>
struct Wrench {
  Vec3<T> force;   // N
  Vec3<T> torque;  // N m, about the body's centre of mass

  constexpr Wrench& operator+=(const Wrench& o) noexcept {
    force += o.force;
    torque += o.torque;
    return *this;
  }
  constexpr Wrench& operator-=(const Wrench& o) noexcept {
    force -= o.force;
    torque -= o.torque;
    return *this;
  }
  constexpr Wrench& operator*=(T s) noexcept {
    force *= s;
    torque *= s;
    return *this;
  }
  friend constexpr Wrench operator+(Wrench a, const Wrench& b) noexcept { return a += b; }
  friend constexpr Wrench operator-(Wrench a, const Wrench& b) noexcept { return a -= b; }
  friend constexpr Wrench operator*(Wrench a, T s) noexcept { return a *= s; }
  friend constexpr Wrench operator*(T s, Wrench a) noexcept { return a *= s; }
  friend constexpr bool operator==(const Wrench&, const Wrench&) noexcept = default;
};

using Vec3d = Vec3<double>;
using Quatd = Quat<double>;
using SymMat3d = SymMat3<double>;
using Posed = Pose<double>;
using Twistd = Twist<double>;
using Wrenchd = Wrench<double>;

template <class T>
bool is_finite(const Pose<T>& p) noexcept {
  return is_finite(p.position) && is_finite(p.rotation);
}
template <class T>
bool is_finite(const Twist<T>& t) noexcept {
  return is_finite(t.linear) && is_finite(t.angular);
}
template <class T>
bool is_finite(const Wrench<T>& w) noexcept {
  return is_finite(w.force) && is_finite(w.torque);
}

static_assert(std::is_trivially_copyable_v<Posed> && std::is_trivially_copyable_v<Wrenchd>);

}  // namespace tactus
