// Small vectors, quaternions and symmetric matrices for real-time code.
//
// Not from a linear-algebra library: these types cross threads, go to the tape and are hashed, so they must be
// trivially copyable; and Debug and Release must give the same bits, so every operation has one fixed order.
// T may also be a Wide: several vectors at once, lane by lane.
// Thread: [any]. Units: the caller's. Bound: no function allocates, loops without bound or throws.
#pragma once

#include <cmath>
#include <type_traits>

#include "rt/base/wide.h"

namespace tactus {

template <class T>
struct Vec3 {
  T x{}, y{}, z{};

  constexpr T& operator[](int i) noexcept { return i == 0 ? x : (i == 1 ? y : z); }
  constexpr const T& operator[](int i) const noexcept { return i == 0 ? x : (i == 1 ? y : z); }
  constexpr Vec3& operator+=(const Vec3& o) noexcept {
    x += o.x;
    y += o.y;
    z += o.z;
    return *this;
  }
  constexpr Vec3& operator-=(const Vec3& o) noexcept {
    x -= o.x;
    y -= o.y;
    z -= o.z;
    return *this;
  }
  constexpr Vec3& operator*=(T s) noexcept {
    x *= s;
    y *= s;
    z *= s;
    return *this;
  }
  friend constexpr Vec3 operator+(Vec3 a, const Vec3& b) noexcept { return a += b; }
  friend constexpr Vec3 operator-(Vec3 a, const Vec3& b) noexcept { return a -= b; }
  friend constexpr Vec3 operator-(const Vec3& a) noexcept { return {-a.x, -a.y, -a.z}; }
  friend constexpr Vec3 operator*(Vec3 a, T s) noexcept { return a *= s; }
  friend constexpr Vec3 operator*(T s, Vec3 a) noexcept { return a *= s; }
  friend constexpr bool operator==(const Vec3&, const Vec3&) noexcept = default;
};

template <class T>
constexpr T dot(const Vec3<T>& a, const Vec3<T>& b) noexcept {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

template <class T>
constexpr Vec3<T> cross(const Vec3<T>& a, const Vec3<T>& b) noexcept {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// Component by component.
template <class T>
constexpr Vec3<T> scale(const Vec3<T>& a, const Vec3<T>& b) noexcept {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}

template <class T>
constexpr T norm_squared(const Vec3<T>& a) noexcept {
  return dot(a, a);
}

template <class T>
T norm(const Vec3<T>& a) noexcept {
  using std::sqrt;
  return sqrt(dot(a, a));
}

template <class T>
Vec3<T> abs(const Vec3<T>& a) noexcept {
  using std::abs;
  return {abs(a.x), abs(a.y), abs(a.z)};
}

// Lane by lane.
template <class Mask, class T>
Vec3<T> select(Mask which, const Vec3<T>& yes, const Vec3<T>& no) noexcept {
  return {select(which, yes.x, no.x), select(which, yes.y, no.y), select(which, yes.z, no.z)};
}

// Unit vector along `a`, or `fallback` if `a` is too short to have a direction.
template <class T>
Vec3<T> normalized_or(const Vec3<T>& a, const Vec3<T>& fallback) noexcept {
  const T length = norm(a);
  return select(length > T(1e-30), a * (T(1) / length), fallback);
}

template <class T>
bool is_finite(const Vec3<T>& a) noexcept {
  return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z);
}

// Two unit vectors that make a right-handed frame (t1, t2, n) with the unit vector n; continuous but for one line.
template <class T>
struct Tangents {
  Vec3<T> t1, t2;
};

template <class T>
Tangents<T> tangents_of(const Vec3<T>& n) noexcept {
  // Cross product with the axis that n is least aligned with (lowest index on a tie).
  const Vec3<T> a = abs(n);
  const Vec3<T> x{T(1), T(0), T(0)}, y{T(0), T(1), T(0)}, z{T(0), T(0), T(1)};
  const Vec3<T> axis = select(both(a.x <= a.y, a.x <= a.z), x, select(a.y <= a.z, y, z));
  const Vec3<T> t1 = normalized_or(cross(axis, n), Vec3<T>{T(0), T(1), T(0)});
  return {t1, cross(n, t1)};
}

// Symmetric 3 x 3 matrix: an inertia, an inverse inertia, an effective mass.
template <class T>
struct SymMat3 {
  T xx{}, yy{}, zz{}, xy{}, xz{}, yz{};

  friend constexpr Vec3<T> operator*(const SymMat3& m, const Vec3<T>& v) noexcept {
    return {m.xx * v.x + m.xy * v.y + m.xz * v.z, m.xy * v.x + m.yy * v.y + m.yz * v.z,
            m.xz * v.x + m.yz * v.y + m.zz * v.z};
  }
  friend constexpr SymMat3 operator+(const SymMat3& a, const SymMat3& b) noexcept {
    return {a.xx + b.xx, a.yy + b.yy, a.zz + b.zz, a.xy + b.xy, a.xz + b.xz, a.yz + b.yz};
  }
  static constexpr SymMat3 identity(T s) noexcept { return {s, s, s, T(0), T(0), T(0)}; }
};

// One lane.
template <class V>
TACTUS_INLINE void set_lane(Vec3<V>& to, int lane, const Vec3<LaneOf<V>>& from) noexcept {
  set_lane(to.x, lane, from.x);
  set_lane(to.y, lane, from.y);
  set_lane(to.z, lane, from.z);
}
template <class V>
TACTUS_INLINE void set_lane(SymMat3<V>& to, int lane, const SymMat3<LaneOf<V>>& from) noexcept {
  set_lane(to.xx, lane, from.xx);
  set_lane(to.yy, lane, from.yy);
  set_lane(to.zz, lane, from.zz);
  set_lane(to.xy, lane, from.xy);
  set_lane(to.xz, lane, from.xz);
  set_lane(to.yz, lane, from.yz);
}
template <class V>
TACTUS_INLINE Vec3<LaneOf<V>> lane_of(const Vec3<V>& from, int lane) noexcept {
  return {lane_of(from.x, lane), lane_of(from.y, lane), lane_of(from.z, lane)};
}

// Inverse of a positive definite matrix; zero if the determinant is not positive.
template <class T>
constexpr SymMat3<T> inverse(const SymMat3<T>& m) noexcept {
  const T c_xx = m.yy * m.zz - m.yz * m.yz, c_xy = m.xz * m.yz - m.xy * m.zz, c_xz = m.xy * m.yz - m.xz * m.yy;
  const T det = m.xx * c_xx + m.xy * c_xy + m.xz * c_xz;
  if (!(det > T(0))) return {};
  const T s = T(1) / det;
  return {s * c_xx, s * (m.xx * m.zz - m.xz * m.xz), s * (m.xx * m.yy - m.xy * m.xy), s * c_xy,
          s * c_xz, s * (m.xy * m.xz - m.xx * m.yz)};
}

// Unit quaternion w + xi + yj + zk. A rotation `world_from_body` maps body vectors to the world.
template <class T>
struct Quat {
  T w{T(1)}, x{}, y{}, z{};

  constexpr Vec3<T> vec() const noexcept { return {x, y, z}; }
  friend constexpr Quat operator*(const Quat& a, const Quat& b) noexcept {
    return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
            a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
  }
  friend constexpr bool operator==(const Quat&, const Quat&) noexcept = default;
};

// Converts to numbers of type S.
template <class S, class T>
constexpr Vec3<S> number_cast(const Vec3<T>& v) noexcept {
  return {static_cast<S>(v.x), static_cast<S>(v.y), static_cast<S>(v.z)};
}
template <class S, class T>
constexpr Quat<S> number_cast(const Quat<T>& q) noexcept {
  return {static_cast<S>(q.w), static_cast<S>(q.x), static_cast<S>(q.y), static_cast<S>(q.z)};
}
template <class S, class T>
constexpr SymMat3<S> number_cast(const SymMat3<T>& m) noexcept {
  return {static_cast<S>(m.xx), static_cast<S>(m.yy), static_cast<S>(m.zz),
          static_cast<S>(m.xy), static_cast<S>(m.xz), static_cast<S>(m.yz)};
}

template <class T>
constexpr Quat<T> conjugate(const Quat<T>& q) noexcept {
  return {q.w, -q.x, -q.y, -q.z};
}

template <class T>
T norm(const Quat<T>& q) noexcept {
  return std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
}

template <class T>
Quat<T> normalized(const Quat<T>& q) noexcept {
  const T s = T(1) / norm(q);
  return {q.w * s, q.x * s, q.y * s, q.z * s};
}

template <class T>
bool is_finite(const Quat<T>& q) noexcept {
  return std::isfinite(q.w) && std::isfinite(q.x) && std::isfinite(q.y) && std::isfinite(q.z);
}

template <class T>
constexpr Vec3<T> rotate(const Quat<T>& q, const Vec3<T>& v) noexcept {
  const Vec3<T> t = T(2) * cross(q.vec(), v);
  return v + q.w * t + cross(q.vec(), t);
}

template <class T>
constexpr Vec3<T> rotate_inverse(const Quat<T>& q, const Vec3<T>& v) noexcept {
  return rotate(conjugate(q), v);
}

// R diag(d) R^T: a tensor that is diagonal in the body frame, in world axes.
template <class T>
constexpr SymMat3<T> rotate_diagonal(const Quat<T>& q, const Vec3<T>& d) noexcept {
  const Vec3<T> a = rotate(q, Vec3<T>{T(1), T(0), T(0)}), b = rotate(q, Vec3<T>{T(0), T(1), T(0)}),
                c = rotate(q, Vec3<T>{T(0), T(0), T(1)});
  return {d.x * a.x * a.x + d.y * b.x * b.x + d.z * c.x * c.x, d.x * a.y * a.y + d.y * b.y * b.y + d.z * c.y * c.y,
          d.x * a.z * a.z + d.y * b.z * b.z + d.z * c.z * c.z, d.x * a.x * a.y + d.y * b.x * b.y + d.z * c.x * c.y,
          d.x * a.x * a.z + d.y * b.x * b.z + d.z * c.x * c.z, d.x * a.y * a.z + d.y * b.y * b.z + d.z * c.y * c.z};
}

// Own sin and cos: a library's may differ in the last bit between a compile-time and a run-time call, and Debug and
// Release must agree. Error below 1e-15 for |angle| < 1e6 rad.
template <class T>
struct SinCos {
  T sin, cos;
};

template <class T>
SinCos<T> sin_cos(T angle_rad) noexcept {
  constexpr double two_over_pi = 0.63661977236758134308, pi_half_high = 1.57079632679489655800,
                   pi_half_low = 6.12323399573676603587e-17;
  const double a = static_cast<double>(angle_rad);
  const double turns = std::floor(a * two_over_pi + 0.5);
  const double r = (a - turns * pi_half_high) - turns * pi_half_low;  // in [-pi/4, pi/4]
  const double r2 = r * r;
  // Taylor series to r^17 and r^16: the first omitted term is below 1e-18. Factors, not divisors, which take ten times
  // as long.
  constexpr double of_sin[] = {1.0 / 272, 1.0 / 210, 1.0 / 156, 1.0 / 110, 1.0 / 72, 1.0 / 42, 1.0 / 20, 1.0 / 6};
  constexpr double of_cos[] = {1.0 / 240, 1.0 / 182, 1.0 / 132, 1.0 / 90, 1.0 / 56, 1.0 / 30, 1.0 / 12, 1.0 / 2};
  double s = 1.0, c = 1.0;
  for (const double factor : of_sin) s = 1.0 - s * r2 * factor;
  for (const double factor : of_cos) c = 1.0 - c * r2 * factor;
  s *= r;
  switch (static_cast<long long>(turns) & 3) {
    case 0:
      return {static_cast<T>(s), static_cast<T>(c)};
    case 1:
      return {static_cast<T>(c), static_cast<T>(-s)};
    case 2:
      return {static_cast<T>(-s), static_cast<T>(-c)};
    default:
      return {static_cast<T>(-c), static_cast<T>(s)};
  }
}

// The rotation by |v| radians about v (exponential map).
template <class T>
Quat<T> quat_from_rotation_vector(const Vec3<T>& v) noexcept {
  const T angle = norm(v);
  if (angle < T(1e-12)) return normalized(Quat<T>{T(1), T(0.5) * v.x, T(0.5) * v.y, T(0.5) * v.z});
  const auto [s, c] = sin_cos(T(0.5) * angle);
  const T k = s / angle;
  return {c, k * v.x, k * v.y, k * v.z};
}

// Twice the vector part of the shorter of q and -q: the rotation vector for small angles, monotone up to half a turn.
template <class T>
constexpr Vec3<T> small_rotation_vector(const Quat<T>& q) noexcept {
  return q.w < T(0) ? T(-2) * q.vec() : T(2) * q.vec();
}

static_assert(std::is_trivially_copyable_v<Vec3<double>> && std::is_trivially_copyable_v<Quat<double>>);

}  // namespace tactus
