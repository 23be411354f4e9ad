// Converts between internal and public vector types. Thread: [any]. Bound: constant time, no allocation.
#pragma once

#include "rt/base/spatial.h"
#include "tactus/types.h"

namespace tactus::library {

inline Vector3 to_public(const Vec3d& v) noexcept { return {v.x, v.y, v.z}; }
inline Quaternion to_public(const Quatd& q) noexcept { return {q.w, q.x, q.y, q.z}; }
inline Vec3d to_inner(const Vector3& v) noexcept { return {v[0], v[1], v[2]}; }
inline Quatd to_inner(const Quaternion& q) noexcept { return {q[0], q[1], q[2], q[3]}; }

}  // namespace tactus::library
